#include "core/geometry/far_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

namespace hapton {
namespace {

Vec3 random_vector(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const double x = normal(random);
  const double y = normal(random);
  return {x, y, normal(random)};
}

TEST(FarPoints, FarthestAgreesWithBruteForce) {
  constexpr std::uint64_t kSeed = 3;
  std::mt19937_64 random(kSeed);
  for (const double scale : {1e-6, 1.0, 1e6}) {
    for (const int count : {1, 8, 9, 1000}) {
      std::vector<Vec3> points;
      for (int i = 0; i < count; ++i) points.push_back(scale * (random_vector(random) + Vec3(7, -3, 2)));
      FarPoints tree(points);
      for (int i = 0; i < 100; ++i) {
        const Vec3 direction = random_vector(random).normalized();
        const Vec3 from = scale * random_vector(random);
        double farthest = -1e300;
        for (const Vec3& point : points) farthest = std::max(farthest, direction.dot(point - from));
        EXPECT_NEAR(tree.find_farthest(direction, from, -1e300), farthest, FarPoints::kRelativeError * tree.extent()) << kSeed;
        EXPECT_EQ(tree.find_farthest(direction, from, farthest + scale), farthest + scale) << "none is farther than that";
      }
    }
  }
}

TEST(FarPoints, WithoutPointsOrExtentNothingIsFarther) {
  EXPECT_EQ(FarPoints({}).find_farthest(Vec3::UnitX(), Vec3::Zero(), 0.5), 0.5);
  EXPECT_EQ(FarPoints({}).extent(), 0.0);
  FarPoints same(std::vector<Vec3>(100, Vec3(1, 2, 3)));
  EXPECT_EQ(same.extent(), 0.0);
  EXPECT_EQ(same.find_farthest(Vec3::UnitZ(), Vec3::Zero(), 0.5), 3.0);
}

// Each query is from the tangent plane of a point on a sphere: it examines about the square root of the number of points, not all of them.
TEST(FarPoints, OnACurvedSurfaceAQueryExaminesFewPoints) {
  for (const std::size_t count : {16000U, 64000U}) {  // for fewer, the bound would be about their number
    std::mt19937_64 random(5);
    std::vector<Vec3> points;
    for (std::size_t i = 0; i < count; ++i) points.push_back(random_vector(random).normalized());
    FarPoints tree(points);
    for (std::size_t i = 0; i < 200; ++i) (void)tree.find_farthest(points[i], points[i], 0.0);
    EXPECT_LT(static_cast<double>(tree.comparisons()), 200.0 * 60.0 * std::sqrt(static_cast<double>(count))) << count;
  }
}

// A distance that is allowed (`least`) bounds the work, however fine the surface is.
TEST(FarPoints, AnAllowedDistanceBoundsTheWorkHoweverManyPointsThereAre) {
  for (const std::size_t count : {1000U, 4000U, 16000U, 64000U}) {
    std::mt19937_64 random(5);
    std::vector<Vec3> points;
    for (std::size_t i = 0; i < count; ++i) points.push_back(random_vector(random).normalized());
    FarPoints tree(points);
    for (std::size_t i = 0; i < 200; ++i) EXPECT_EQ(tree.find_farthest(points[i], points[i], 0.02), 0.02);
    EXPECT_LT(tree.comparisons(), 200U * 600U) << count;
  }
}

// Points that are equally far, such as those on the rim of a notch, are not examined one by one.
TEST(FarPoints, OfEquallyFarPointsFewAreExamined) {
  std::vector<Vec3> points;
  for (int i = 0; i < 100; ++i) {
    for (int k = 0; k < 100; ++k) points.emplace_back(i, k, 0.0);
  }
  FarPoints tree(points);
  for (int n = 0; n < 100; ++n) EXPECT_EQ(tree.find_farthest(Vec3::UnitZ(), Vec3(0, 0, -1), 0.0), 1.0);
  EXPECT_LT(tree.comparisons(), 100U * 100U);
}

}  // namespace
}  // namespace hapton
