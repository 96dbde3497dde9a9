#include "scene/polygon.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

namespace hapton {
namespace {

Vec3 area_vector(const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles) {
  Vec3 sum = Vec3::Zero();
  for (const Triangle& t : triangles) sum += 0.5 * (vertices[t[1]] - vertices[t[0]]).cross(vertices[t[2]] - vertices[t[0]]);
  return sum;
}

// The area counted without signs: equal to the signed one only when no triangle is turned round or lies over another.
double total_area(const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles) {
  double sum = 0;
  for (const Triangle& t : triangles) sum += 0.5 * (vertices[t[1]] - vertices[t[0]]).cross(vertices[t[2]] - vertices[t[0]]).norm();
  return sum;
}

std::vector<std::uint32_t> corners_of(const std::vector<Vec3>& vertices) {
  std::vector<std::uint32_t> corners(vertices.size());
  std::iota(corners.begin(), corners.end(), 0U);
  return corners;
}

void expect_covered(const std::vector<Vec3>& vertices, const Vec3& expected_area) {
  std::vector<Triangle> triangles;
  ASSERT_TRUE(triangulate_polygon(corners_of(vertices), vertices, triangles));
  EXPECT_EQ(triangles.size(), vertices.size() - 2);
  EXPECT_LT((area_vector(vertices, triangles) - expected_area).norm(), 1e-12 * expected_area.norm());
  EXPECT_NEAR(total_area(vertices, triangles), expected_area.norm(), 1e-12 * expected_area.norm());
}

TEST(Polygon, CoversConvexOnes) {
  expect_covered({{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}}, Vec3(0, 0, 2));
  expect_covered({{0, 0, 0}, {0, 1, 0}, {2, 1, 0}, {2, 0, 0}}, Vec3(0, 0, -2));
}

TEST(Polygon, CoversADart) {
  for (int turn = 0; turn < 4; ++turn) {
    std::vector<Vec3> dart = {{0, 0, 0}, {2, 0, 0}, {0.5, 0.5, 0}, {0, 2, 0}};
    std::rotate(dart.begin(), dart.begin() + turn, dart.end());
    expect_covered(dart, Vec3(0, 0, 1));
  }
}

TEST(Polygon, CoversAComb) {
  std::vector<Vec3> comb = {{0, 0, 0}, {20, 0, 0}};
  for (int tooth = 10; tooth-- > 0;) {
    comb.emplace_back(2 * tooth + 1.5, 5, 0);
    comb.emplace_back(2 * tooth + 0.5, 1, 0);
  }
  Vec3 area = Vec3::Zero();
  for (std::size_t i = 0; i < comb.size(); ++i) area += 0.5 * comb[i].cross(comb[(i + 1) % comb.size()]);
  expect_covered(comb, area);
  // The same at any scale and in any plane: nothing depends on an absolute size.
  for (const double scale : {1e-9, 1e9}) {
    const Quat q = Eigen::AngleAxisd(1.0, Vec3(1, 2, 3).normalized()) * Quat::Identity();
    std::vector<Vec3> posed = comb;
    for (Vec3& v : posed) v = q * (scale * v);
    std::vector<Triangle> triangles;
    ASSERT_TRUE(triangulate_polygon(corners_of(posed), posed, triangles));
    EXPECT_NEAR(total_area(posed, triangles) / (scale * scale), area.norm(), 1e-9);
  }
}

TEST(Polygon, CoversRandomStars) {
  const unsigned seed = 7;
  RecordProperty("seed", static_cast<int>(seed));
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> radius(0.1, 1.0);
  for (int round = 0; round < 200; ++round) {
    const int n = 4 + static_cast<int>(random() % 60);
    std::vector<Vec3> star;
    for (int i = 0; i < n; ++i) {
      const double angle = 2 * std::numbers::pi * i / n;
      star.push_back(radius(random) * Vec3(std::cos(angle), std::sin(angle), 0));
    }
    double area = 0;
    for (int i = 0; i < n; ++i) area += 0.5 * star[i].cross(star[(i + 1) % n]).z();
    expect_covered(star, Vec3(0, 0, area));
  }
}

TEST(Polygon, GivesAFanWhereNothingBetterExists) {
  for (const std::vector<Vec3>& bad : {std::vector<Vec3>{{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}},
                                       std::vector<Vec3>{{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}},
                                       std::vector<Vec3>{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}}) {
    std::vector<Triangle> triangles;
    ASSERT_TRUE(triangulate_polygon(corners_of(bad), bad, triangles));
    EXPECT_EQ(triangles.size(), bad.size() - 2);
  }
}

TEST(Polygon, RejectsOnlyHollowOnesWithTooManyCorners) {
  std::vector<Vec3> round;
  for (int i = 0; i < 5000; ++i)
    round.emplace_back(std::cos(2 * std::numbers::pi * i / 5000), std::sin(2 * std::numbers::pi * i / 5000), 0);
  std::vector<Triangle> triangles;
  EXPECT_TRUE(triangulate_polygon(corners_of(round), round, triangles));
  EXPECT_EQ(triangles.size(), 4998U);
  round[7] *= 0.5;
  EXPECT_FALSE(triangulate_polygon(corners_of(round), round, triangles));
  EXPECT_EQ(triangles.size(), 4998U) << "nothing may be appended";
}

}  // namespace
}  // namespace hapton
