#include "core/geometry/point_in_mesh.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

TEST(PointInMesh, SphereByRadius) {
  const PointInMesh sphere(make_icosphere(1.0, 4));
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> symmetric(-1.1, 1.1);
  int inside = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 p(symmetric(random), symmetric(random), symmetric(random));
    if (std::abs(p.norm() - 1.0) < 0.01) continue;
    ASSERT_EQ(sphere.is_inside(p), p.norm() < 1.0) << p.transpose();
    inside += p.norm() < 1.0;
  }
  EXPECT_GT(inside, 1000);
}

TEST(PointInMesh, RaysThroughVerticesAndEdges) {
  const PointInMesh box(make_box(Vec3::Ones(), 4));
  for (int i = -6; i <= 6; ++i) {
    for (int j = -6; j <= 6; ++j) {
      for (int k = -6; k <= 6; ++k) {
        if (std::max({std::abs(i), std::abs(j), std::abs(k)}) == 4) continue;  // on the surface
        const Vec3 p(i / 8.0, j / 8.0, k / 8.0);
        ASSERT_EQ(box.is_inside(p), p.cwiseAbs().maxCoeff() < 0.5) << p.transpose();
      }
    }
  }
}

TEST(PointInMesh, TheHoleOfATorusIsOutside) {
  const PointInMesh torus(make_torus(1.0, 0.3, 60, 30));
  EXPECT_FALSE(torus.is_inside(Vec3::Zero()));
  EXPECT_TRUE(torus.is_inside(Vec3(-1.0, 0.0, 0.1)));
  EXPECT_FALSE(torus.is_inside(Vec3(-1.0, 0.0, 0.4)));
}

// A file may contain such slivers. The rectangles around them cover the grid a hundred thousand times.
TEST(PointInMesh, AHundredThousandSliversAcrossTheMesh) {
  TriangleMesh mesh = make_box(Vec3::Ones(), 4);
  for (int n = 0; n < 50'000; ++n) {
    const double x = 1e-5 * n - 0.25;
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {Vec3(x, -0.5, -0.5), Vec3(x, 0.5, 0.5), Vec3(x, 0.5, 0.499)});
    // Two triangles with opposite windings: their contributions cancel.
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.triangles.push_back({first, first + 2, first + 1});
  }
  const PointInMesh box(mesh);
  for (const double z : {-0.45, 0.01, 0.45}) {
    EXPECT_TRUE(box.is_inside(Vec3(-0.3, z, z)));
    EXPECT_TRUE(box.is_inside(Vec3(0.1, -z, z)));
    EXPECT_FALSE(box.is_inside(Vec3(-0.6, z, z)));
    EXPECT_FALSE(box.is_inside(Vec3(0.1, z, 0.6)));
  }
}

TEST(PointInMesh, InvertedAndFarAway) {
  const Vec3 move(1e6, -1e6, 1e6);
  const PointInMesh shell(scaled_and_moved(flipped(make_icosphere(1.0, 3)), 1e-3, move * 1e-3));
  EXPECT_TRUE(shell.is_inside(move * 1e-3));
  EXPECT_FALSE(shell.is_inside(move * 1e-3 + Vec3(0.0011, 0, 0)));
}

// Each triangle of the cylinder's side reaches over all rows of cells. With larger cells the answers are the same.
TEST(PointInMesh, LargeTrianglesAreListedNoMoreOftenThanTheLimit) {
  constexpr std::size_t kMaxListings = 4;  // per triangle
  const TriangleMesh mesh = make_cylinder(1.0, 1.0, 600);
  const PointInMesh unlimited(mesh);
  const PointInMesh limited(mesh, 1e-7, kMaxListings);
  EXPECT_GT(unlimited.listings(), kMaxListings * mesh.triangles.size());
  EXPECT_LE(limited.listings(), kMaxListings * mesh.triangles.size());
  EXPECT_GE(limited.listings(), mesh.triangles.size());
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> symmetric(-1.1, 1.1);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p(symmetric(random), symmetric(random), symmetric(random));
    ASSERT_EQ(limited.is_inside(p), unlimited.is_inside(p)) << p.transpose();
  }
}

TEST(PointInMesh, APlaceThatIsNotANumberIsOutside) {
  const PointInMesh box(make_box(Vec3::Ones(), 4));
  ASSERT_TRUE(box.is_inside(Vec3::Zero()));
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 p = Vec3::Zero();
    p[axis] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(box.is_inside(p)) << "axis " << axis;
  }
}

TEST(PointInMesh, DistanceTestsEveryTriangle) {
  const PointInMesh box(make_box(Vec3::Ones(), 3));
  EXPECT_NEAR(box.compute_distance(Vec3(0.1, 0.2, 0.4)), 0.1, 1e-15);
  EXPECT_NEAR(box.compute_distance(Vec3(1.5, 1.5, 1.5)), std::sqrt(3.0), 1e-15);
}

}  // namespace
}  // namespace hapton
