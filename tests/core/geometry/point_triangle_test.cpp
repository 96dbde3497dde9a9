#include "core/geometry/point_triangle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace hapton {
namespace {

// Distance by minimising over the parameters u, v of the triangle's points, first on a grid over all of it, then on finer grids around the
// best point: slow and simple.
double distance_by_search(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  double best = std::numeric_limits<double>::infinity();
  double best_u = 0.0;
  double best_v = 0.0;
  double step = 0.05;
  for (int level = 0; level < 14; ++level) {
    const double u0 = best_u;
    const double v0 = best_v;
    const int reach = level == 0 ? 20 : 4;
    for (int i = -reach; i <= reach; ++i) {
      for (int j = -reach; j <= reach; ++j) {
        const double u = std::clamp(u0 + i * step, 0.0, 1.0);
        const double v = std::clamp(v0 + j * step, 0.0, 1.0 - u);
        const double d = (a + u * (b - a) + v * (c - a) - p).norm();
        if (d < best) {
          best = d;
          best_u = u;
          best_v = v;
        }
      }
    }
    step *= 0.35;
  }
  return best;
}

TEST(PointTriangle, DistanceAgreesWithSearchOnRandomTriangles) {
  constexpr unsigned kSeed = 90210;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> coordinate(-1.0, 1.0);
  const auto point = [&] { return Vec3(coordinate(random), coordinate(random), coordinate(random)); };
  for (int i = 0; i < 300; ++i) {
    const Vec3 a = point();
    const Vec3 b = point();
    const Vec3 c = point();
    const Vec3 p = 1.5 * point();
    const Separation s = separation_from_triangle(p, a, b, c);
    EXPECT_NEAR(s.distance, distance_by_search(p, a, b, c), 2e-5);
    EXPECT_NEAR(s.normal.norm(), 1.0, 1e-14);
    EXPECT_NEAR((s.nearest + s.distance * s.normal - p).norm(), 0.0, 1e-14);
  }
}

TEST(PointTriangle, NormalIsTheGradientOfTheDistance) {
  constexpr unsigned kSeed = 7;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> coordinate(-1.0, 1.0);
  const auto point = [&] { return Vec3(coordinate(random), coordinate(random), coordinate(random)); };
  for (int i = 0; i < 2000; ++i) {
    const Vec3 a = point();
    const Vec3 b = point();
    const Vec3 c = point();
    const Vec3 p = 1.5 * point();
    const Separation s = separation_from_triangle(p, a, b, c);
    if (s.distance < 1e-2) continue;
    const double h = 1e-6;
    for (int k = 0; k < 3; ++k) {
      const Vec3 step = h * Vec3::Unit(k);
      const double slope =
          (separation_from_triangle(p + step, a, b, c).distance - separation_from_triangle(p - step, a, b, c).distance) / (2 * h);
      EXPECT_NEAR(slope, s.normal[k], 1e-3);
    }
  }
}

TEST(PointTriangle, EveryOrderOfTheCornersGivesTheSameDistance) {
  constexpr unsigned kSeed = 31;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> coordinate(-1.0, 1.0);
  const auto point = [&] { return Vec3(coordinate(random), coordinate(random), coordinate(random)); };
  for (int i = 0; i < 5000; ++i) {
    const std::array<Vec3, 3> t = {point(), point(), point()};
    const Vec3 p = point();
    const double d = separation_from_triangle(p, t[0], t[1], t[2]).distance;
    for (const auto& [x, y, z] :
         {std::array{1, 2, 0}, std::array{2, 0, 1}, std::array{0, 2, 1}, std::array{2, 1, 0}, std::array{1, 0, 2}}) {
      EXPECT_NEAR(separation_from_triangle(p, t[x], t[y], t[z]).distance, d, 1e-15);
    }
  }
}

TEST(PointTriangle, TinyDistancesKeepTheirDigitsAndUnitNormals) {
  const Vec3 a(0, 0, 0);
  const Vec3 b(1, 0, 0);
  const Vec3 c(0, 1, 0);
  for (const double h : {0x1p-20, 0x1p-30, 0x1p-40}) {
    const Separation face = separation_from_triangle({0.25, 0.25, h}, a, b, c);
    EXPECT_EQ(face.feature, Feature::face);
    EXPECT_EQ(face.distance, h);
    const Separation edge = separation_from_triangle({0.7, -h, h}, a, b, c);
    EXPECT_EQ(edge.feature, Feature::edge);
    EXPECT_NEAR(edge.distance, std::sqrt(2.0) * h, 1e-6 * h);
    EXPECT_NEAR(edge.normal.norm(), 1.0, 1e-14);
  }
}

TEST(PointTriangle, DegenerateTrianglesActAsEdges) {
  // Coordinates are multiples of a power of two, so that edge vectors are exact, as TouchGeometry makes them.
  const Vec3 a(0, 0, 0);
  const Vec3 b(1, 0, 0);
  const Vec3 sliver(0.5, 0x1p-50, 0);
  const Separation over = separation_from_triangle({0.5, 0x1p-51, 0.25}, a, b, sliver);
  EXPECT_NEAR(over.distance, 0.25, 1e-15);
  EXPECT_NEAR(over.normal.z(), 1.0, 1e-12);
  const Separation flat = separation_from_triangle({0.5, 0.25, 0}, a, b, Vec3(0.75, 0, 0));
  EXPECT_EQ(flat.distance, 0.25);
  const Separation dot = separation_from_triangle({3, 4, 0}, a, a, a);
  EXPECT_EQ(dot.distance, 5.0);
  EXPECT_EQ(dot.feature, Feature::vertex);
  EXPECT_TRUE(separation_from_triangle(a, a, a, a).normal.allFinite());
}

}  // namespace
}  // namespace hapton
