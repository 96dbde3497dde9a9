#include "core/force/reference/convex_sweep.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <random>

namespace hapton {
namespace {

constexpr double kRounding = 0x1p-48;

TEST(ConvexSweep, HitsAFaceAnEdgeAndACornerHeadOn) {
  const PreparedTriangle triangle(Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0));
  for (const Vec3& over : {Vec3(0.2, 0.2, 0), Vec3(0.5, 0, 0), Vec3(0, 0, 0), Vec3(0.5, 0.5, 0)}) {
    const SweepHit sweep = sweep_point(triangle, over + Vec3(0, 0, 1), Vec3(0, 0, -2), 1.0, 0.25, 1e-14, kRounding);
    ASSERT_TRUE(sweep.hit);
    EXPECT_NEAR(sweep.t, 0.375, 1e-13);
  }
}

TEST(ConvexSweep, MissesWhatItPassesAndWhatItLeaves) {
  const PreparedTriangle triangle(Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0));
  EXPECT_FALSE(sweep_point(triangle, Vec3(-1, -1, 0.3), Vec3(4, 4, 0), 1.0, 0.25, 1e-14, kRounding).hit);
  EXPECT_FALSE(sweep_point(triangle, Vec3(0.2, 0.2, 0.25), Vec3(0, 0, 1), 1.0, 0.25, 1e-14, kRounding).hit);
  EXPECT_FALSE(sweep_point(triangle, Vec3(0.2, 0.2, 1), Vec3(0, 0, -2), 0.3, 0.25, 1e-14, kRounding).hit);
}

// The motion is sampled densely: before a hit the distance is nowhere below the limit, and at the hit it is the limit; without a hit it is
// never below the limit.
TEST(ConvexSweep, AgreesWithDenseSamplingOfTheDistance) {
  const std::uint64_t seed = 5;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> symmetric(-1.0, 1.0);
  auto draw = [&] { return Vec3(symmetric(random), symmetric(random), symmetric(random)); };
  int hits = 0;
  for (int i = 0; i < 4000; ++i) {
    const Vec3 a = draw(), b = draw();
    Vec3 c = draw();
    if (i % 3 == 0) c = a + symmetric(random) * (b - a) + 1e-9 * c;  // needles and caps
    const PreparedTriangle triangle(a, b, c);
    const Vec3 from = 2.0 * draw();
    const Vec3 motion = 0.5 * (a + b) - from + 0.5 * draw();
    const double limit = i % 2 == 0 ? 0.1 : 0x1p-32;
    if (closest_point(triangle, from).distance <= limit) continue;
    const SweepHit sweep = sweep_point(triangle, from, 1.5 * motion, 1.0, limit, 0x1p-47, kRounding);
    const double until = sweep.hit ? sweep.t : 1.0;
    EXPECT_FALSE(sweep.exhausted);
    for (int k = 0; k <= 100; ++k) ASSERT_GE(closest_point(triangle, from + (until * k / 100.0) * 1.5 * motion).distance, limit - 1e-13);
    if (sweep.hit) {
      ++hits;
      ASSERT_NEAR(closest_point(triangle, from + sweep.t * 1.5 * motion).distance, limit, 2.0 * 0x1p-47 + 1e-15);
    }
  }
  EXPECT_GT(hits, 500);
}

// A tiny sphere that slides over a face and onto a coplanar one stays free; a motion that leads down by more than the tolerance hits it.
TEST(ConvexSweep, SlidesOverACoplanarEdge) {
  const double rest_offset = 0x1p-32;
  const PreparedTriangle next(Vec3(0.5, -1, 0), Vec3(1.5, -1, 0.0), Vec3(0.5, 1, 0));
  const SweepHit sweep = sweep_point(next, Vec3(0.1, -0.3, rest_offset), Vec3(0.7, 0.1, 0), 1.0, rest_offset - 0x1p-38, 0x1p-48, kRounding);
  EXPECT_FALSE(sweep.hit);
  const SweepHit blocked =
      sweep_point(next, Vec3(0.1, -0.3, rest_offset), Vec3(0.7, 0.1, -1e-10), 1.0, rest_offset - 0x1p-38, 0x1p-48, kRounding);
  EXPECT_TRUE(blocked.hit);
}

// From a start near the boundary, at the rest offset, nearly along the plane: the sphere must not pass through the triangle.
TEST(ConvexSweep, NeverCrossesFromARandomStartAtTheRestOffset) {
  const std::uint64_t seed = 6;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> symmetric(-1.0, 1.0);
  const double rest_offset = 0x1p-32;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 a(symmetric(random), symmetric(random), 0), b(symmetric(random), symmetric(random), 0),
        c(symmetric(random), symmetric(random), 0);
    const PreparedTriangle triangle(a, b, c);
    // The start is at the rest offset from a point of an edge, in a random direction.
    const Vec3 on = a + std::abs(symmetric(random)) * (b - a);
    Vec3 out(symmetric(random), symmetric(random), symmetric(random));
    Vec3 from = on + rest_offset * out.normalized();
    const double start = closest_point(triangle, from).distance;
    if (start < 0.5 * rest_offset) continue;
    const Vec3 motion(symmetric(random), symmetric(random), 1e-3 * symmetric(random));
    const double limit = std::min(rest_offset - 0x1p-38, start - 0x1p-47);
    const SweepHit sweep = sweep_point(triangle, from, motion, 1.0, limit, 0x1p-48, kRounding);
    const double until = sweep.hit ? sweep.t : 1.0;
    for (int k = 0; k <= 60; ++k) {
      const double t = until * std::pow(2.0, -0.5 * k);
      ASSERT_GE(closest_point(triangle, from + t * motion).distance, limit - 300 * kRounding) << i;
    }
  }
}

}  // namespace
}  // namespace hapton
