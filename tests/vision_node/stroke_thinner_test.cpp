#include "vision_node/stroke_thinner.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace hapton {
namespace {

double distance_to_line(const Vec3& p, const std::vector<Vec3>& line) {
  double least = (p - line.front()).norm();
  for (std::size_t i = 1; i < line.size(); ++i) {
    const Vec3 along = line[i] - line[i - 1];
    const double t = std::clamp((p - line[i - 1]).dot(along) / along.squaredNorm(), 0.0, 1.0);
    least = std::min(least, (p - line[i - 1] - t * along).norm());
  }
  return least;
}

std::vector<Vec3> thin(const std::vector<Vec3>& points, double bound_m) {
  StrokeThinner thinner(bound_m);
  for (const Vec3& p : points) thinner.add(p);
  return thinner.points();
}

double largest_distance(const std::vector<Vec3>& points, const std::vector<Vec3>& line) {
  double most = 0.0;
  for (const Vec3& p : points) most = std::max(most, distance_to_line(p, line));
  return most;
}

double length_of(const std::vector<Vec3>& line) {
  double length = 0.0;
  for (std::size_t i = 1; i < line.size(); ++i) length += (line[i] - line[i - 1]).norm();
  return length;
}

// A chord that deviates from a circle by at most e spans an angle of at most 2 acos(1 - e / r). This gives the smallest number of vertices
// and the smallest length of a polyline within the bound.
TEST(StrokeThinner, ACircleIsWithinTheBoundWithFewVertices) {
  constexpr double kRadius = 0.02;
  constexpr int kPoints = 2000;
  std::vector<Vec3> circle;
  for (int i = 0; i <= kPoints; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kPoints;
    circle.emplace_back(kRadius * std::cos(angle), kRadius * std::sin(angle), 0.01);
  }
  for (const double bound_m : {1e-5, 5e-5, 2e-4}) {
    const std::vector<Vec3> line = thin(circle, bound_m);
    EXPECT_LE(largest_distance(circle, line), bound_m);
    // Half of the bound is reserved for points that the thinner ignores, so a chord may deviate by the other half.
    const double largest_angle = 2.0 * std::acos(1.0 - 0.5 * bound_m / kRadius);
    const double fewest_vertices = 2.0 * std::numbers::pi / largest_angle;
    EXPECT_LE(static_cast<double>(line.size()), 1.3 * fewest_vertices + 2.0) << bound_m;
    // The polyline is inscribed: it is shorter by a share of at most 1 - sin(a/2) / (a/2), chord against arc, and by the gap at its end.
    const double smallest_share = std::sin(0.5 * largest_angle) / (0.5 * largest_angle);
    EXPECT_LE(length_of(line), 2.0 * std::numbers::pi * kRadius);
    EXPECT_GE(length_of(line), smallest_share * 2.0 * std::numbers::pi * kRadius - bound_m);
    for (const Vec3& vertex : line) EXPECT_NEAR(vertex.head<2>().norm(), kRadius, 1e-15) << "vertices are points that were touched";
  }
}

TEST(StrokeThinner, AStraightLineHasTwoVertices) {
  std::vector<Vec3> points;
  for (int i = 0; i <= 200; ++i) points.emplace_back(1e-3 * i, 2e-3 * i, 0.0);
  const std::vector<Vec3> line = thin(points, 1e-4);
  ASSERT_EQ(line.size(), 2U);
  EXPECT_EQ(line.front(), points.front());
  EXPECT_EQ(line.back(), points.back());
}

TEST(StrokeThinner, WhatIsKeptStaysAVertex) {
  StrokeThinner thinner(1e-4);
  std::vector<Vec3> kept;
  for (int i = 0; i <= 200; ++i) {
    thinner.add({1e-3 * i, 2e-3 * i, 0.0});
    if (i % 60 == 50) {
      thinner.keep_last();
      kept.emplace_back(1e-3 * i, 2e-3 * i, 0.0);
      EXPECT_FALSE(thinner.add(kept.back())) << "at rest there it adds nothing";
    }
  }
  const std::vector<Vec3>& line = thinner.points();
  ASSERT_EQ(line.size(), 2 + kept.size());
  for (std::size_t i = 0; i < kept.size(); ++i) EXPECT_EQ(line[i + 1], kept[i]);
}

TEST(StrokeThinner, ACornerIsKept) {
  std::vector<Vec3> points;
  for (int i = 0; i <= 100; ++i) points.emplace_back(1e-3 * i, 0.0, 0.0);
  for (int i = 1; i <= 100; ++i) points.emplace_back(0.1, 1e-3 * i, 0.0);
  const std::vector<Vec3> line = thin(points, 1e-4);
  ASSERT_EQ(line.size(), 3U);
  EXPECT_LE((line[1] - Vec3(0.1, 0, 0)).norm(), 1e-3) << "within a point of the corner";
  EXPECT_LE(largest_distance(points, line), 1e-4);
}

// The pen goes out and back on the same line: the far end must not be lost.
TEST(StrokeThinner, AReversalIsKept) {
  const std::vector<Vec3> points = {{0, 0, 0}, {0.05, 0, 0}, {0.1, 0, 0}, {0.06, 0, 0}, {0.02, 0, 0}};
  EXPECT_LE(largest_distance(points, thin(points, 1e-4)), 1e-4);
}

TEST(StrokeThinner, AnyWalkIsWithinTheBound) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 random(seed);
    std::normal_distribution<double> step(0.0, 1.0);
    constexpr double kBound = 1e-4;
    const double size = kBound * std::pow(10.0, static_cast<double>(seed % 5) - 2.0);
    std::vector<Vec3> walk = {Vec3::Zero()};
    for (int i = 0; i < 3000; ++i) walk.push_back(walk.back() + size * Vec3(step(random), step(random), step(random)));
    const std::vector<Vec3> line = thin(walk, kBound);
    EXPECT_LE(largest_distance(walk, line), kBound);
    EXPECT_EQ(line.front(), walk.front());
  }
}

TEST(StrokeThinner, APenAtRestAddsNothing) {
  StrokeThinner thinner(1e-4);
  EXPECT_TRUE(thinner.add({0.1, 0.2, 0.3}));
  for (int i = 0; i < 10000; ++i) EXPECT_FALSE(thinner.add(Vec3(0.1, 0.2, 0.3) + Vec3((i % 3) * 1e-5, 0, 0)));
  EXPECT_EQ(thinner.points().size(), 1U);
}

TEST(StrokeThinner, TheResultScalesWithTheScene) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> step(0.0, 1.0);
  std::vector<Vec3> walk = {Vec3::Zero()};
  for (int i = 0; i < 500; ++i) walk.push_back(walk.back() + Vec3(step(random), step(random), step(random)));
  std::vector<Vec3> large;
  for (const Vec3& p : walk) large.push_back(1024.0 * p);
  const std::vector<Vec3> line = thin(walk, 2.0);
  const std::vector<Vec3> large_line = thin(large, 2048.0);
  ASSERT_EQ(line.size(), large_line.size());
  for (std::size_t i = 0; i < line.size(); ++i) EXPECT_EQ(Vec3(1024.0 * line[i]), large_line[i]);
}

}  // namespace
}  // namespace hapton
