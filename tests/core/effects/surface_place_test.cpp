#include "core/effects/surface_place.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace hapton {
namespace {

Mat3 random_corners(std::mt19937& random, double scale) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  return scale * Mat3::NullaryExpr([&] { return unit(random); });
}

// The gradient of a linear number on a triangle: differences along the edges stay the same, and it has no component along the normal.
TEST(SurfacePlace, TheGradientMovesWithTheTriangle) {
  std::mt19937 random(3);
  for (const double scale : {1e-6, 1.0, 1e6}) {
    for (int i = 0; i < 200; ++i) {
      const Mat3 rest = random_corners(random, scale);
      const Mat3 deformed = random_corners(random, scale);
      const Vec3 e1 = rest.col(1) - rest.col(0);
      const Vec3 e2 = rest.col(2) - rest.col(0);
      const Vec3 rest_normal = e1.cross(e2);
      if (rest_normal.norm() < 1e-2 * scale * scale) continue;
      const Vec3 gradient = (0.3 * e2 - 0.7 * e1).cross(rest_normal) / rest_normal.squaredNorm();  // 0.3 along e1, 0.7 along e2
      ASSERT_NEAR(gradient.dot(e1), 0.3, 1e-9);
      const Vec3 moved = gradient_of_deformed(rest, deformed) * gradient;
      EXPECT_NEAR(moved.dot(deformed.col(1) - deformed.col(0)), 0.3, 1e-6) << scale;
      EXPECT_NEAR(moved.dot(deformed.col(2) - deformed.col(0)), gradient.dot(e2), 1e-6) << scale;
      const Vec3 normal = (deformed.col(1) - deformed.col(0)).cross(deformed.col(2) - deformed.col(0)).normalized();
      EXPECT_NEAR(moved.dot(normal) * scale, 0.0, 1e-6 * (1.0 + moved.norm() * scale)) << scale;
    }
  }
}

TEST(SurfacePlace, OfATurnedTriangleTheGradientIsTurned) {
  std::mt19937 random(4);
  const Mat3 rest = random_corners(random, 1.0);
  const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(2, 1, 2) / 3.0).toRotationMatrix();
  EXPECT_LT((gradient_of_deformed(rest, turn * rest) - turn).norm(), 1e-12);
}

TEST(SurfacePlace, ATriangleWithoutAreaChangesNothing) {
  const Mat3 flat = Mat3::Ones();
  std::mt19937 random(5);
  EXPECT_TRUE(gradient_of_deformed(random_corners(random, 1.0), flat).allFinite());
  EXPECT_EQ(gradient_of_deformed(flat, flat), Mat3(Mat3::Identity()));
}

}  // namespace
}  // namespace hapton
