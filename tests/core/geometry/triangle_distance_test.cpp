#include "core/geometry/triangle_distance.h"

#include <gtest/gtest.h>

#include <random>

#include "core/geometry/closest_point.h"

namespace hapton {
namespace {

struct Random {
  std::mt19937_64 engine;
  std::uniform_real_distribution<double> unit{-1.0, 1.0};
  Vec3 point() { return {unit(engine), unit(engine), unit(engine)}; }
};

// A random triangle; one in three is a needle or has no area.
std::array<Vec3, 3> make_triangle(Random& random, int i) {
  const Vec3 a = random.point();
  const Vec3 b = random.point();
  Vec3 c = random.point();
  if (i % 9 == 0) c = a + 0.4 * (b - a) + 1e-7 * random.point();
  if (i % 9 == 3) c = 0.5 * (a + b);
  if (i % 9 == 6) return {a, a, a};
  return {a, b, c};
}

TEST(TriangleDistance, AgreesWithTheClosestPoint) {
  Random random{std::mt19937_64(21)};
  for (int i = 0; i < 20000; ++i) {
    const auto [a, b, c] = make_triangle(random, i);
    const Vec3 p = 2.0 * random.point();
    const double expected = closest_point(a, b, c, p).distance;
    EXPECT_NEAR(std::sqrt(triangle_distance_squared(p, a, b, c)), expected, 1e-9 * (1.0 + expected)) << i;
  }
}

TEST(TriangleDistance, FourLanesAreTheScalarBitForBit) {
  Random random{std::mt19937_64(22)};
  for (int i = 0; i < 5000; ++i) {
    detail::Of3<Lanes4> a;
    detail::Of3<Lanes4> b;
    detail::Of3<Lanes4> c;
    std::array<std::array<Vec3, 3>, 4> t;
    for (int lane = 0; lane < 4; ++lane) {
      t[lane] = make_triangle(random, 4 * i + lane);
      const auto set_lane = [lane](detail::Of3<Lanes4>& to, const Vec3& v) {
        to.x[lane] = v.x();
        to.y[lane] = v.y();
        to.z[lane] = v.z();
      };
      set_lane(a, t[lane][0]);
      set_lane(b, t[lane][1]);
      set_lane(c, t[lane][2]);
    }
    const Vec3 p = random.point();
    const Vec3 q = random.point();
    const auto lanes = [](const Vec3& v) { return detail::Of3<Lanes4>{Lanes4{} + v.x(), Lanes4{} + v.y(), Lanes4{} + v.z()}; };
    const Lanes4 point = triangle_distance_squared<Lanes4>(lanes(p), a, b, c);
    const Lanes4 segment = segment_triangle_distance_squared<Lanes4>(lanes(p), lanes(q), a, b, c);
    for (int lane = 0; lane < 4; ++lane) {
      EXPECT_EQ(point[lane], triangle_distance_squared(p, t[lane][0], t[lane][1], t[lane][2]));
      EXPECT_EQ(segment[lane],
                segment_triangle_distance_squared<double>(of3(p), of3(q), of3(t[lane][0]), of3(t[lane][1]), of3(t[lane][2])));
    }
  }
}

// The segment's distance is the smallest over its points; samples can only give a larger one.
TEST(SegmentTriangleDistance, IsTheLeastOverThePoints) {
  Random random{std::mt19937_64(23)};
  for (int i = 0; i < 3000; ++i) {
    const auto [a, b, c] = make_triangle(random, i);
    const Vec3 p = 1.5 * random.point();
    const Vec3 q = p + random.point();
    const double found = std::sqrt(segment_triangle_distance_squared<double>(of3(p), of3(q), of3(a), of3(b), of3(c)));
    double sampled = 1e9;
    constexpr int kSamples = 400;
    for (int s = 0; s <= kSamples; ++s) {
      sampled = std::min(sampled, std::sqrt(triangle_distance_squared(p + (q - p) * (s / double{kSamples}), a, b, c)));
    }
    EXPECT_LE(found, sampled + 1e-9) << i;
    EXPECT_GE(found, sampled - (q - p).norm() / kSamples - 1e-9) << i;
  }
}

TEST(SegmentTriangleDistance, IsZeroThroughTheFace) {
  const auto distance_squared = [](const Vec3& p, const Vec3& q) {
    return segment_triangle_distance_squared<double>(of3(p), of3(q), of3({0, 0, 0}), of3({1, 0, 0}), of3({0, 1, 0}));
  };
  EXPECT_EQ(distance_squared({0.2, 0.2, 1.0}, {0.3, 0.2, -1.0}), 0.0);
  EXPECT_EQ(distance_squared({0.3, 0.2, -1.0}, {0.2, 0.2, 1.0}), 0.0);
  EXPECT_NEAR(distance_squared({0.2, 0.2, 1.0}, {0.3, 0.2, 0.5}), 0.25, 1e-12);
  EXPECT_NEAR(distance_squared({2.0, 0.0, -1.0}, {2.0, 0.0, 1.0}), 1.0, 1e-12);
}

}  // namespace
}  // namespace hapton
