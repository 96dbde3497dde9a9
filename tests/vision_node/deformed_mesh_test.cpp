#include "vision_node/deformed_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <vector>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

constexpr double kGrowth = 0.5;

// In one second the x of each vertex grows to (1 + kGrowth) x, and so does that of every point of the surface.
std::shared_ptr<const MeshDeformation> make_growth(const TriangleMesh& mesh) {
  MorphTarget target;
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    target.vertices.push_back(v);
    target.displacements.emplace_back(kGrowth * mesh.vertices[v].x(), 0, 0);
  }
  return std::make_shared<const MeshDeformation>(std::vector<MorphTarget>{target}, std::vector<MorphKey>{{0.0, {0.0}}, {1.0, {1.0}}},
                                                 false);
}

Vec3 grown(const Vec3& p, double weight) { return {(1.0 + weight * kGrowth) * p.x(), p.y(), p.z()}; }

struct DeformedMeshTest : testing::Test {
  std::shared_ptr<const TriangleMesh> mesh = std::make_shared<const TriangleMesh>(make_bumpy_sphere(0.05, 0.25, 1'000, 1));
  DeformedMesh deformed{mesh, make_growth(*mesh)};
};

TEST_F(DeformedMeshTest, APointOfTheSurfaceGoesAlongWithIt) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (std::size_t t = 0; t < mesh->triangles.size(); t += 7) {
    const double u = unit(random), v = (1.0 - u) * unit(random);
    const Vec3 p = u * mesh->corner(t, 0) + v * mesh->corner(t, 1) + (1.0 - u - v) * mesh->corner(t, 2);
    for (const double weight : {0.0, 0.3, 1.0}) {
      deformed.set_time(weight);
      EXPECT_LE((deformed.place(p) - grown(p, weight)).norm(), 1e-15) << t << " at " << weight;
    }
  }
}

TEST_F(DeformedMeshTest, WhatIsTouchedIsFoundInThePresentShapeAndNamedByWhereItIsAtRest) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (const double weight : {0.0, 0.3, 1.0}) {
    deformed.set_time(weight);
    for (std::size_t t = 0; t < mesh->triangles.size(); t += 11) {
      const Vec3 p = 0.2 * mesh->corner(t, 0) + 0.3 * mesh->corner(t, 1) + 0.5 * mesh->corner(t, 2);
      const DeformedMesh::TouchedPoint touched = deformed.find_closest(grown(p, weight));
      EXPECT_LE((touched.p_rest - p).norm(), 1e-15) << t << " at " << weight;
      EXPECT_EQ(touched.triangle, t);
    }
  }
}

// If a program gives the same shape, points are placed equally.
TEST_F(DeformedMeshTest, OneThatAProgramDeformsIsAsOneThatDeformsByItself) {
  double weight = 0.0;
  bool is_known = true;
  int calls = 0;
  DeformedMesh programmed(mesh, [&]() -> std::optional<std::vector<Vec3>> {
    ++calls;
    if (!is_known) return std::nullopt;
    std::vector<Vec3> vertices;
    for (const Vec3& p : mesh->vertices) vertices.push_back(grown(p, weight));
    return vertices;
  });
  EXPECT_FALSE(programmed.set_time(1.0));
  for (const double next : {0.0, 0.3, 1.0}) {
    weight = next;
    programmed.invalidate_vertices();
    deformed.set_time(weight);
    for (std::size_t t = 0; t < mesh->triangles.size(); t += 11) {
      const Vec3 p = 0.2 * mesh->corner(t, 0) + 0.3 * mesh->corner(t, 1) + 0.5 * mesh->corner(t, 2);
      EXPECT_LE((programmed.place(p) - deformed.place(p)).norm(), 1e-15) << t << " at " << weight;
      const DeformedMesh::TouchedPoint touched = programmed.find_closest(grown(p, weight));
      EXPECT_LE((touched.p_rest - p).norm(), 1e-15) << t << " at " << weight;
      EXPECT_EQ(touched.triangle, t);
    }
  }
  EXPECT_EQ(calls, 3) << "once for each shape";
  is_known = false;
  programmed.invalidate_vertices();
  const Vec3 corner = mesh->corner(5, 0);
  EXPECT_LE((programmed.place(corner) - grown(corner, 1.0)).norm(), 1e-15) << "unknown: it stays";
}

TEST_F(DeformedMeshTest, ItReportsWhenItsShapeHasChanged) {
  EXPECT_FALSE(deformed.set_time(0.0)) << "at rest";
  EXPECT_TRUE(deformed.set_time(0.5));
  EXPECT_FALSE(deformed.set_time(0.5));
  EXPECT_TRUE(deformed.set_time(2.0));
  EXPECT_FALSE(deformed.set_time(3.0)) << "it has ended";
}

}  // namespace
}  // namespace hapton
