#include "vision_node/surface_finder.h"

#include <gtest/gtest.h>

#include <random>

#include "core/geometry/closest_point.h"
#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

Vec3 find_by_brute_force(const TriangleMesh& mesh, const Vec3& p) {
  ClosestPoint best = closest_point(mesh.corner(0, 0), mesh.corner(0, 1), mesh.corner(0, 2), p);
  for (std::size_t t = 1; t < mesh.triangles.size(); ++t) {
    const ClosestPoint found = closest_point(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2), p);
    if (found.distance < best.distance) best = found;
  }
  return best.point;
}

TEST(SurfaceFinder, FindsWhatAllTrianglesTogetherGive) {
  constexpr std::uint64_t kSeed = 4;
  RecordProperty("seed", std::to_string(kSeed));
  TriangleMesh mesh = make_bumpy_sphere(0.05, 0.25, 2'000, 1);
  // Far from the origin, where single precision alone would be too coarse.
  const Vec3 offset(100.0, -20.0, 5.0);
  for (Vec3& vertex : mesh.vertices) vertex += offset;
  const SurfaceFinder finder(std::make_shared<const TriangleMesh>(mesh));
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> coordinate(-0.1, 0.1);
  for (int i = 0; i < 300; ++i) {
    const Vec3 p = offset + Vec3(coordinate(random), coordinate(random), coordinate(random));
    const Vec3 expected = find_by_brute_force(mesh, p);
    EXPECT_LE((finder.find_closest(p).point - p).norm(), (expected - p).norm() * (1.0 + 1e-12)) << i;
  }
}

TEST(SurfaceFinder, FindsTheSameWithTheVerticesElsewhere) {
  constexpr std::uint64_t kSeed = 7;
  RecordProperty("seed", std::to_string(kSeed));
  const auto mesh = std::make_shared<const TriangleMesh>(make_bumpy_sphere(0.05, 0.25, 2'000, 1));
  const SurfaceFinder finder(mesh);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> coordinate(-0.1, 0.1);
  for (const double moved_m : {0.0, 0.003, 0.03}) {
    TriangleMesh moved = *mesh;
    for (Vec3& vertex : moved.vertices) vertex += moved_m * Vec3(coordinate(random), coordinate(random), coordinate(random)).normalized();
    for (int i = 0; i < 100; ++i) {
      const Vec3 p(coordinate(random), coordinate(random), coordinate(random));
      const SurfaceFinder::SurfacePoint found = finder.find_closest(p, moved.vertices, moved_m);
      EXPECT_LE((found.point - p).norm(), (find_by_brute_force(moved, p) - p).norm() * (1.0 + 1e-12)) << i;
      Vec3 mixed = Vec3::Zero();
      for (int k = 0; k < 3; ++k) mixed += found.barycentric[k] * moved.corner(found.triangle, k);
      EXPECT_LE((mixed - found.point).norm(), 1e-15);
    }
  }
}

TEST(SurfaceFinder, APointOnTheSurfaceIsItself) {
  const auto mesh = std::make_shared<const TriangleMesh>(make_bumpy_sphere(0.05, 0.25, 500, 2));
  const SurfaceFinder finder(mesh);
  for (const Vec3& vertex : mesh->vertices) EXPECT_LE((finder.find_closest(vertex).point - vertex).norm(), 1e-15);
}

TEST(SurfaceFinder, OneTriangleIsEnough) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  const SurfaceFinder finder(std::make_shared<const TriangleMesh>(mesh));
  EXPECT_EQ(finder.find_closest({0.25, 0.25, 3.0}).point, Vec3(0.25, 0.25, 0.0));
  EXPECT_EQ(finder.find_closest({0.25, 0.25, 3.0}).barycentric, Vec3(0.5, 0.25, 0.25));
  EXPECT_EQ(finder.find_closest({-5.0, -5.0, 3.0}).point, Vec3(0, 0, 0));
}

}  // namespace
}  // namespace hapton
