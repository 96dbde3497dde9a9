#include "core/geometry/mesh_shapes.h"

#include <gtest/gtest.h>
#include <cmath>
#include <numbers>

#include "core/geometry/mesh_measures.h"

namespace hapton {
namespace {

constexpr double kPi = std::numbers::pi;

void expect_closed_with_volume(const TriangleMesh& mesh, double volume, double relative) {
  const EdgeCensus census = count_edges(mesh);
  EXPECT_TRUE(census.closed()) << census.boundary << " boundary, " << census.non_manifold << " non-manifold, " << census.inconsistent
                               << " inconsistent";
  EXPECT_NEAR(compute_volume(mesh), volume, relative * volume);
}

TEST(MeshShapes, IcosphereIsClosedRoundAndOfKnownCount) {
  const TriangleMesh mesh = make_icosphere(0.05, 5);
  EXPECT_EQ(mesh.triangles.size(), 20480u);
  for (const Vec3& vertex : mesh.vertices) EXPECT_NEAR(vertex.norm(), 0.05, 1e-16);
  expect_closed_with_volume(mesh, 4.0 / 3.0 * kPi * std::pow(0.05, 3), 2e-3);
  EXPECT_LT(compute_volume(mesh), 4.0 / 3.0 * kPi * std::pow(0.05, 3));
}

TEST(MeshShapes, BoxVolumeAndAreaAreExact) {
  for (int cells : {1, 3}) {
    const TriangleMesh mesh = make_box(Vec3(1.0, 2.0, 3.0), cells);
    EXPECT_EQ(mesh.triangles.size(), 12u * cells * cells);
    expect_closed_with_volume(mesh, 6.0, 1e-14);
    EXPECT_NEAR(compute_area(mesh), 22.0, 1e-12);
  }
}

TEST(MeshShapes, CylinderIsThePrismOverItsPolygon) {
  const int sides = 40;
  expect_closed_with_volume(make_cylinder(0.5, 2.0, sides, 3), 2.0 * 0.5 * sides * 0.25 * std::sin(2.0 * kPi / sides), 1e-13);
}

TEST(MeshShapes, TorusIsClosed) { expect_closed_with_volume(make_torus(1.0, 0.3, 200, 80), 2.0 * kPi * kPi * 0.09, 3e-3); }

TEST(MeshShapes, PlaneGridIsOpenAndFacesUp) {
  const TriangleMesh mesh = make_plane_grid(2.0, 4);
  EXPECT_EQ(count_edges(mesh).boundary, 16u);
  EXPECT_EQ(count_edges(mesh).inconsistent, 0u);
  EXPECT_NEAR(compute_area(mesh), 4.0, 1e-14);
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    EXPECT_GT((mesh.corner(i, 1) - mesh.corner(i, 0)).cross(mesh.corner(i, 2) - mesh.corner(i, 0)).z(), 0.0);
  }
}

TEST(MeshShapes, BumpySphereTakesItsSeedAndItsCount) {
  const TriangleMesh one = make_bumpy_sphere(0.05, 0.2, 5000, 1);
  const TriangleMesh same = make_bumpy_sphere(0.05, 0.2, 5000, 1);
  const TriangleMesh other = make_bumpy_sphere(0.05, 0.2, 5000, 2);
  EXPECT_EQ(one.triangles.size(), 5120u);
  EXPECT_TRUE(count_edges(one).closed());
  EXPECT_GT(compute_volume(one), 0.0);
  EXPECT_EQ(one.vertices, same.vertices);
  EXPECT_NE(one.vertices, other.vertices);
}

TEST(MeshShapes, PrismsOverConcaveOutlinesAreClosed) {
  const double groove = 0.2 * 0.2 * std::tan(0.25);
  expect_closed_with_volume(make_gutter(1.0, 0.2, 0.5, 3), 1.0 - groove, 1e-12);
  expect_closed_with_volume(make_staircase(1.0, 4, 2), 0.5 + 0.5 / 4, 1e-12);
  expect_closed_with_volume(make_pit(1.0, 0.3), 1.0 - 0.8 * 0.8 * 0.3 / 3.0, 1e-12);
  expect_closed_with_volume(make_thin_wall(1.0, 1e-3, 2), 1e-3, 1e-12);
}

TEST(MeshShapes, FlippedHasNegativeVolumeAndJoinedAddsUp) {
  const TriangleMesh box = make_box(Vec3::Ones());
  EXPECT_NEAR(compute_volume(flipped(box)), -1.0, 1e-14);
  const TriangleMesh both = joined(box, scaled_and_moved(box, 2.0, Vec3(5.0, 0.0, 0.0)));
  EXPECT_NEAR(compute_volume(both), 9.0, 1e-12);
  EXPECT_TRUE(count_edges(both).closed());
}

// The normal curvature along each edge is computed from the turn of the normal between its ends.
TEST(MeshShapes, ARoughSphereHasTheCurvatureRequested) {
  const double curvature_radius = 0.0007;
  const TriangleMesh mesh = make_rough_sphere(0.01, curvature_radius, 0.0025, 80000, 3);
  EXPECT_EQ(mesh.triangles.size(), 81920u);
  std::vector<Vec3> normals(mesh.vertices.size(), Vec3::Zero());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Vec3 n = (mesh.corner(i, 1) - mesh.corner(i, 0)).cross(mesh.corner(i, 2) - mesh.corner(i, 0));
    for (const std::uint32_t vertex : mesh.triangles[i]) normals[vertex] += n;
  }
  double sum_of_squares = 0.0;
  std::size_t sharp_edges = 0, edges = 0;
  for (const Triangle& triangle : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = triangle[k], b = triangle[(k + 1) % 3];
      const Vec3 edge = mesh.vertices[b] - mesh.vertices[a];
      const double curvature = (normals[b].normalized() - normals[a].normalized()).dot(edge) / edge.squaredNorm();
      sum_of_squares += curvature * curvature;
      sharp_edges += curvature > 1.0 / 0.001 ? 1 : 0;  // convex, and sharper than 1 mm
      ++edges;
    }
  }
  const double rms_radius = 1.0 / std::sqrt(sum_of_squares / static_cast<double>(edges));
  EXPECT_GT(rms_radius, 0.5 * curvature_radius);
  EXPECT_LT(rms_radius, 2.0 * curvature_radius);  // on slopes the surface bends less
  EXPECT_GT(sharp_edges, edges / 10);
  EXPECT_EQ(make_rough_sphere(0.01, curvature_radius, 0.0025, 80000, 3).vertices, mesh.vertices);
  EXPECT_NE(make_rough_sphere(0.01, curvature_radius, 0.0025, 80000, 4).vertices, mesh.vertices);
}

}  // namespace
}  // namespace hapton
