#include "core/geometry/point_in_mesh.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
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

TEST(PointInMesh, InvertedAndFarAway) {
  const Vec3 move(1e6, -1e6, 1e6);
  const PointInMesh shell(scaled_and_moved(flipped(make_icosphere(1.0, 3)), 1e-3, move * 1e-3));
  EXPECT_TRUE(shell.is_inside(move * 1e-3));
  EXPECT_FALSE(shell.is_inside(move * 1e-3 + Vec3(0.0011, 0, 0)));
}

TEST(PointInMesh, DistanceTestsEveryTriangle) {
  const PointInMesh box(make_box(Vec3::Ones(), 3));
  EXPECT_NEAR(box.compute_distance(Vec3(0.1, 0.2, 0.4)), 0.1, 1e-15);
  EXPECT_NEAR(box.compute_distance(Vec3(1.5, 1.5, 1.5)), std::sqrt(3.0), 1e-15);
}

}  // namespace
}  // namespace hapton
