#include "core/collision/triangle_box.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace hapton {
namespace {

// The part of a polygon below the plane axis = limit (side +1) or above it (side -1): Sutherland and Hodgman.
std::vector<Vec3> clip(const std::vector<Vec3>& polygon, int axis, double limit, double side) {
  std::vector<Vec3> clipped;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vec3& a = polygon[i];
    const Vec3& b = polygon[(i + 1) % polygon.size()];
    const double da = side * (limit - a[axis]);
    const double db = side * (limit - b[axis]);
    if (da >= 0) {
      clipped.push_back(a);
    }
    if ((da > 0 && db < 0) || (da < 0 && db > 0)) {
      clipped.push_back(a + da / (da - db) * (b - a));
    }
  }
  return clipped;
}

bool touches_by_clipping(const std::array<Vec3, 3>& triangle, const Vec3& low, const Vec3& high) {
  std::vector<Vec3> polygon(triangle.begin(), triangle.end());
  for (int axis = 0; axis < 3; ++axis) {
    polygon = clip(clip(polygon, axis, high[axis], 1.0), axis, low[axis], -1.0);
  }
  return !polygon.empty();
}

TEST(TriangleBox, AgreesWithClipping) {
  constexpr std::uint64_t kSeed = 3;
  RecordProperty("seed", std::to_string(kSeed));
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto vector = [&] { return Vec3(unit(random), unit(random), unit(random)); };
  int touching = 0;
  int apart_but_boxes_meet = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 a = vector();
    const std::array<Vec3, 3> triangle = {a, a + vector(), a + vector()};
    const Vec3 corner = vector();
    const Vec3 low = corner.array() - 0.3;
    const Vec3 high = corner.array() + 0.3;
    const bool expected = touches_by_clipping(triangle, low, high);
    // The box is shrunk and grown by far more than rounding, so that only clear cases are compared.
    if (touches_by_clipping(triangle, low.array() + 1e-9, high.array() - 1e-9) !=
        touches_by_clipping(triangle, low.array() - 1e-9, high.array() + 1e-9)) {
      continue;
    }
    ASSERT_EQ(may_touch(triangle, low, high), expected) << i;
    const Vec3 tri_low = triangle[0].cwiseMin(triangle[1]).cwiseMin(triangle[2]);
    const Vec3 tri_high = triangle[0].cwiseMax(triangle[1]).cwiseMax(triangle[2]);
    const bool boxes_meet = (tri_low.array() <= high.array()).all() && (tri_high.array() >= low.array()).all();
    touching += expected ? 1 : 0;
    apart_but_boxes_meet += !expected && boxes_meet ? 1 : 0;
  }
  EXPECT_GT(touching, 1500);
  EXPECT_GT(apart_but_boxes_meet, 500);  // so not only the bounding boxes were compared
}

TEST(TriangleBox, TouchingASideOrACornerCounts) {
  const std::array<Vec3, 3> face = {Vec3(1, 0.2, 0.2), Vec3(1, 0.8, 0.2), Vec3(1, 0.2, 0.8)};  // in the box's side x = 1
  EXPECT_TRUE(may_touch(face, Vec3::Zero(), Vec3::Ones()));
  const std::array<Vec3, 3> corner = {Vec3(1, 1, 1), Vec3(2, 1, 1), Vec3(1, 2, 3)};
  EXPECT_TRUE(may_touch(corner, Vec3::Zero(), Vec3::Ones()));
  const std::array<Vec3, 3> far = {Vec3(1.0001, 0, 0), Vec3(2, 0, 0), Vec3(2, 1, 0)};
  EXPECT_FALSE(may_touch(far, Vec3::Zero(), Vec3::Ones()));
}

// A point of the triangle inside of the box proves that they touch, however thin the triangle is.
TEST(TriangleBox, NeverMissesAPointOfANeedle) {
  constexpr std::uint64_t kSeed = 8;
  RecordProperty("seed", std::to_string(kSeed));
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto vector = [&] { return Vec3(unit(random), unit(random), unit(random)); };
  for (int i = 0; i < 20000; ++i) {
    const Vec3 a = vector();
    const Vec3 b = vector();
    const double thin = std::pow(10.0, -20.0 * unit(random));
    const Vec3 c = a + unit(random) * (b - a) + thin * vector();
    const double s = unit(random);
    const Vec3 p = a + s * (b - a) + (1 - s) * unit(random) * (c - a);
    // The point sits on the box's corner.
    const Vec3 sign = (vector().array() < 0.5).select(Vec3::Constant(-1.0), Vec3::Ones());
    const Vec3 q = p + 0.1 * sign;
    ASSERT_TRUE(may_touch({a, b, c}, p.cwiseMin(q), p.cwiseMax(q))) << i;
  }
}

}  // namespace
}  // namespace hapton
