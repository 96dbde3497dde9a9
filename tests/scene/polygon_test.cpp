#include "scene/polygon.h"

#include <gtest/gtest.h>

#include <algorithm>
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

// The sum of the areas without sign: it equals the signed sum only if no triangle is flipped or overlaps another.
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

// Brute-force twin: it cuts ears in the same order, but tests each corner against all remaining ones, every time. Pre: the polygon is
// in z = 0 and counter-clockwise. Empty: it found no ear to cut.
std::vector<Triangle> cut_ears_by_brute_force(const std::vector<Vec3>& vertices) {
  const auto turn = [&](std::uint32_t i, std::uint32_t j, std::uint32_t k) {
    const Vec3 &a = vertices[i], &b = vertices[j], &c = vertices[k];
    return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
  };
  std::vector<std::uint32_t> ring = corners_of(vertices);
  std::vector<Triangle> triangles;
  std::size_t at = 0;
  for (std::size_t misses = 0; ring.size() > 3;) {
    const std::size_t n = ring.size();
    at %= n;
    const Triangle ear = {ring[(at + n - 1) % n], ring[at], ring[(at + 1) % n]};
    const auto is_in_ear = [&](std::uint32_t p) {
      for (const std::uint32_t ear_corner : ear) {
        if (vertices[p] == vertices[ear_corner]) return false;
      }
      return turn(ear[0], ear[1], p) >= 0 && turn(ear[1], ear[2], p) >= 0 && turn(ear[2], ear[0], p) >= 0;
    };
    if (!(turn(ear[0], ear[1], ear[2]) > 0) || std::any_of(ring.begin(), ring.end(), is_in_ear)) {
      if (++misses == n) return {};
      ++at;
      continue;
    }
    triangles.push_back(ear);
    ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(at));
    misses = 0;
  }
  triangles.push_back({ring[0], ring[1], ring[2]});
  return triangles;
}

// The outline of a spiral band: outwards along its outer edge, then back along its inner edge.
std::vector<Vec3> spiral(int corners, double turns) {
  std::vector<Vec3> vertices;
  const int half = corners / 2;
  for (int i = 0; i < corners; ++i) {
    const int along = i < half ? i : corners - 1 - i;
    const double angle = 2 * std::numbers::pi * turns * along / half;
    const double radius = angle + (i < half ? 3.0 : 1.5);
    vertices.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0);
  }
  return vertices;
}

TEST(Polygon, CutsTheEarsThatItsTwinCuts) {
  const unsigned seed = 11;
  RecordProperty("seed", static_cast<int>(seed));
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  int compared_polygons = 0;
  for (int round = 0; round < 300; ++round) {
    const int n = 5 + static_cast<int>(random() % 120);
    std::vector<Vec3> polygon = spiral(n, 0.05 * (round % 60));
    if (round % 3 > 0) polygon.resize(static_cast<std::size_t>(n));
    for (int i = 0; i < n && round % 3 > 0; ++i) {
      // Random stars, or random polygons that cross themselves; these have corners on a grid, so that some of them coincide.
      const double angle = 2 * std::numbers::pi * i / n;
      polygon[static_cast<std::size_t>(i)] = round % 3 == 1 ? Vec3((0.6 + 0.4 * unit(random)) * Vec3(std::cos(angle), std::sin(angle), 0))
                                                            : Vec3(std::round(8 * unit(random)), std::round(8 * unit(random)), 0);
    }
    double area = 0;
    for (int i = 0; i < n; ++i) area += polygon[static_cast<std::size_t>(i)].cross(polygon[static_cast<std::size_t>((i + 1) % n)]).z();
    if (area < 0) std::reverse(polygon.begin(), polygon.end());
    const std::vector<Triangle> expected = cut_ears_by_brute_force(polygon);
    if (area == 0 || expected.empty()) continue;  // triangulate_polygon() makes a fan then
    ++compared_polygons;
    std::vector<Triangle> triangles;
    ASSERT_TRUE(triangulate_polygon(corners_of(polygon), polygon, triangles));
    // A convex polygon becomes a fan, whose triangles are in another order than the twin's.
    if (triangles[0] == Triangle{0, 1, 2} &&
        triangles.back() == Triangle{0, static_cast<std::uint32_t>(n - 2), static_cast<std::uint32_t>(n - 1)})
      continue;
    EXPECT_EQ(triangles, expected) << round;
  }
  EXPECT_GT(compared_polygons, 150);
}

TEST(Polygon, TakesQuadraticTimeAtWorst) {
  for (const double turns : {1.0, 20.0, 128.0}) {
    for (const int first : {0, 1, 256, 512}) {
      std::vector<Vec3> polygon = spiral(static_cast<int>(kMaxPolygonCorners), turns);
      std::rotate(polygon.begin(), polygon.begin() + first, polygon.end());
      std::vector<Triangle> triangles;
      std::size_t work = 0;
      ASSERT_TRUE(triangulate_polygon(corners_of(polygon), polygon, triangles, &work));
      EXPECT_EQ(triangles.size(), kMaxPolygonCorners - 2);
      EXPECT_GT(work, kMaxPolygonCorners);
      EXPECT_LE(work, 4 * kMaxPolygonCorners * kMaxPolygonCorners);
    }
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
  std::vector<Vec3> circle;
  for (int i = 0; i < 5000; ++i)
    circle.emplace_back(std::cos(2 * std::numbers::pi * i / 5000), std::sin(2 * std::numbers::pi * i / 5000), 0);
  std::vector<Triangle> triangles;
  EXPECT_TRUE(triangulate_polygon(corners_of(circle), circle, triangles));
  EXPECT_EQ(triangles.size(), 4998U);
  circle[7] *= 0.5;
  EXPECT_FALSE(triangulate_polygon(corners_of(circle), circle, triangles));
  EXPECT_EQ(triangles.size(), 4998U) << "nothing may be appended";
}

}  // namespace
}  // namespace hapton
