#include "core/geometry/largest_disc.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace hapton {
namespace {

using Points = std::vector<Eigen::Vector2d>;

std::vector<Segment2> closed_outline(const Points& points, double turn_rad = 0.0) {
  const Eigen::Rotation2D<double> turn(turn_rad);
  std::vector<Segment2> edges;
  for (std::size_t n = 0; n < points.size(); ++n) {
    edges.emplace_back(Eigen::Vector2d(turn * points[n]), Eigen::Vector2d(turn * points[(n + 1) % points.size()]));
  }
  return edges;
}

Points arc(double radius, double from_rad, double to_rad, int edges) {
  Points points;
  for (int n = 0; n <= edges; ++n) {
    const double angle = from_rad + (to_rad - from_rad) * n / edges;
    points.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
  }
  return points;
}

void expect_disc(const std::vector<Segment2>& edges, double diameter) {
  const double found = largest_disc(edges);
  EXPECT_GE(found, diameter * (1.0 - 1e-12));
  EXPECT_LE(found, 1.0101 * diameter);
}

TEST(LargestDisc, OfPolygonsThatHaveOneInClosedForm) {
  for (const double turn_rad : {0.0, 0.3, 0.7, 2.0}) {
    expect_disc(closed_outline({{0, 0}, {3, 0}, {0, 4}}, turn_rad), 2.0);
    expect_disc(closed_outline({{0, 0}, {7, 0}, {7, 2}, {0, 2}}, turn_rad), 2.0);
    expect_disc(closed_outline({{0, 0}, {100, 0}, {100, 0.1}, {0, 0.1}}, turn_rad), 0.1);
    expect_disc(closed_outline(arc(1.0, 0.0, 2.0 * std::numbers::pi, 400), turn_rad), 2.0 * std::cos(std::numbers::pi / 400));
  }
}

// A round hole of diameter 10 that continues in a slot of 1 x 40.
TEST(LargestDisc, ASlotDoesNotMakeARoundHoleNarrower) {
  const double half_angle = std::asin(0.1);
  Points keyhole = arc(5.0, half_angle, 2.0 * std::numbers::pi - half_angle, 200);
  keyhole.emplace_back(45.0, -0.5);
  keyhole.emplace_back(45.0, 0.5);
  const double found = largest_disc(closed_outline(keyhole, 0.4));
  EXPECT_GE(found, 9.98);
  EXPECT_LE(found, 10.3);
}

// A hole of diameter 0.02 at the end of a slit of 0.001 x 5.2 that follows a circle: a long rim of many edges must not reduce accuracy.
TEST(LargestDisc, ALongRimOfManyEdgesDoesNotMakeItWider) {
  constexpr int kEdges = 10'000;
  Points slit = arc(1.0005, 0.01, 5.2, kEdges);
  const Points inner_side = arc(0.9995, 5.2, 0.01, kEdges);
  slit.insert(slit.end(), inner_side.begin(), inner_side.end());
  const double half_angle = std::asin(0.05);
  for (const Eigen::Vector2d& p : arc(0.01, 0.5 * std::numbers::pi + half_angle, 2.5 * std::numbers::pi - half_angle, 200)) {
    slit.push_back(Eigen::Vector2d(1.0, 0.0) + p);
  }
  const double found = largest_disc(closed_outline(slit, 0.4));
  EXPECT_GE(found, 0.01999);
  EXPECT_LE(found, 0.0206);
}

// The rim has so many teeth that it is about three times as long as a circle.
TEST(LargestDisc, AJaggedRimDoesNotMakeItNarrower) {
  Points star;
  for (int n = 0; n < 400; ++n) {
    const double angle = 2.0 * std::numbers::pi * n / 400;
    star.emplace_back((n % 2 == 0 ? 1.0 : 1.05) * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  const double found = largest_disc(closed_outline(star));
  EXPECT_GE(found, 2.0 * std::cos(std::numbers::pi / 200));
  EXPECT_LE(found, 2.05);
}

TEST(LargestDisc, WhatIsWithinTwoOutlinesIsOutside) {
  std::vector<Segment2> ring = closed_outline({{-3, -3}, {3, -3}, {3, 3}, {-3, 3}});
  for (const Segment2& edge : closed_outline({{-2, -2}, {2, -2}, {2, 2}, {-2, 2}})) ring.push_back(edge);
  const double found = largest_disc(ring);
  const double in_corner = 2.0 * std::sqrt(2.0) / (1.0 + std::sqrt(2.0));  // touches two outer edges and the inner corner
  EXPECT_NEAR(found, in_corner, 0.012 * in_corner);
}

// Compared with the deepest point of a fine grid: no other point is deeper by more than half a diagonal of the grid's squares.
TEST(LargestDisc, OfRandomStarsIsThatOfTheDeepestPoint) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> radius(0.2, 1.0);
  for (int shape = 0; shape < 20; ++shape) {
    Points star;
    for (int n = 0; n < 12; ++n) {
      const double angle = 2.0 * std::numbers::pi * n / 12;
      star.emplace_back(radius(random) * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    }
    double deepest = 0.0;
    const auto edges = closed_outline(star);
    for (int i = -100; i <= 100; ++i) {
      for (int k = -100; k <= 100; ++k) {
        const Eigen::Vector2d p(0.01 * i, 0.01 * k);
        double nearest = std::numeric_limits<double>::infinity();
        double winding = 0.0;
        for (const auto& [a, b] : edges) {
          const Eigen::Vector2d u = a - p;
          const Eigen::Vector2d v = b - p;
          winding += std::atan2(u.x() * v.y() - u.y() * v.x(), u.dot(v));
          const double share = std::clamp(-u.dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
          nearest = std::min(nearest, (u + share * (b - a)).norm());
        }
        if (std::abs(winding) > 3.0) deepest = std::max(deepest, nearest);
      }
    }
    const double found = 0.5 * largest_disc(edges);
    EXPECT_GE(found, deepest) << shape;
    EXPECT_LE(found, 1.0101 * (deepest + 0.0071)) << shape;
  }
}

TEST(LargestDisc, ANegligibleDiameterMayBeReportedInstead) {
  const auto slot = closed_outline({{0, 0}, {100, 0}, {100, 0.1}, {0, 0.1}}, 1.0);
  EXPECT_LE(largest_disc(slot, 0.2), 0.2);
  EXPECT_GE(largest_disc(slot, 0.2), 0.1);
  const auto bent = closed_outline({{0, 0}, {100, 0}, {100, 100}, {99.9, 100}, {99.9, 0.1}, {0, 0.1}});
  EXPECT_LE(largest_disc(bent, 1.0), 1.0);
  EXPECT_GE(largest_disc(bent, 1.0), 0.1);
  expect_disc(bent, 0.2 * (2.0 - std::sqrt(2.0)));
}

TEST(LargestDisc, OfNothingIsNone) {
  EXPECT_EQ(largest_disc({}), 0.0);
  EXPECT_EQ(largest_disc(closed_outline({{1, 1}, {2, 1}, {3, 1}})), 0.0);
  EXPECT_LT(largest_disc(closed_outline({{0, 0}, {1, 1}, {2, 2}})), 1e-15);
  EXPECT_EQ(largest_disc(closed_outline({{0, 0}, {1, 1}, {std::numeric_limits<double>::quiet_NaN(), 2}})), 0.0);
}

}  // namespace
}  // namespace hapton
