#include "core/sculpt/closest_surface_point.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

constexpr double kBallRadiusM = 0.03;
constexpr double kSpacingM = 0.001;

CarvedField make_clay() {
  auto field = CarvedField::make(make_icosphere(kBallRadiusM, 5), kSpacingM);
  EXPECT_TRUE(field.has_value()) << field.error().what;
  return std::move(*field);
}

Vec3 random_direction(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  return Vec3(normal(random), normal(random), normal(random)).normalized();
}

// The given points lie inside and outside the ball, beyond the band and outside the grid.
TEST(ClosestSurfacePoint, OfABallIsOnTheRayFromItsCentre) {
  const CarvedField field = make_clay();
  std::mt19937_64 random(5);
  for (const double height_m : {-0.005, -0.0004, 0.0, 0.0004, 0.002, 0.006, 0.05, 1.0}) {
    for (int i = 0; i < 100; ++i) {
      const Vec3 direction = random_direction(random);
      const auto found = find_closest_surface_point(field, (kBallRadiusM + height_m) * direction);
      ASSERT_TRUE(found);
      // The icosphere is flat between its vertices, the field between its nodes; the closest point of a facet is beside the ray by the
      // facet's slope, 0.03, times the distance; from inside it is farther beside, as towards the centre all directions become equal.
      EXPECT_NEAR(found->norm(), kBallRadiusM, 0.05 * kSpacingM) << height_m;
      EXPECT_LE((*found - kBallRadiusM * direction).norm(), 0.1 * kSpacingM + 0.05 * std::abs(height_m)) << height_m;
      // Three steps of Newton's method leave 2e-8 spacings at most, two leave up to 1e-6.
      EXPECT_LE(std::abs(field.value(*found)), 1e-7 * kSpacingM) << "on the zero set";
    }
  }
}

// A ball in a pit of its own radius, which it carved, touches the pit's bottom: there it has the least room.
TEST(ClosestSurfacePoint, InAPitIsItsBottom) {
  CarvedField field = make_clay();
  constexpr double kPitRadiusM = 0.004, kPitEndM = 0.008;
  field.carve({{0, 0.05, 0}, {0, kPitEndM, 0}, kPitRadiusM});
  for (const double gap : {0.0003, 0.001, 0.002}) {
    const Vec3 p(0, kPitEndM - gap, 0);
    const auto found = find_closest_surface_point(field, p);
    ASSERT_TRUE(found);
    EXPECT_NEAR((*found - Vec3(0, kPitEndM, 0)).norm(), kPitRadiusM, 0.05 * kSpacingM) << "on the sphere at its end";
    EXPECT_NEAR((*found - p).norm(), kPitRadiusM - gap, 0.05 * kSpacingM);
    // Near the centre of the pit all its points are about equally far, so the roughness of the field moves the result along the pit.
    EXPECT_LE((*found - Vec3(0, kPitEndM - kPitRadiusM, 0)).norm(), 0.05 * kSpacingM * kPitRadiusM / gap) << gap;
  }
  const auto wall = find_closest_surface_point(field, {0.001, 0.02, 0});
  ASSERT_TRUE(wall);
  EXPECT_LE((*wall - Vec3(kPitRadiusM, 0.02, 0)).norm(), 0.1 * kSpacingM);
}

// The twin: in a ball around p, a little smaller than the distance found, no point is on the other side of the surface.
TEST(ClosestSurfacePoint, NothingOfTheSurfaceIsNearer) {
  constexpr std::uint64_t kSeed = 6;
  RecordProperty("seed", std::to_string(kSeed));
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> coordinate(-0.03, 0.03), size(0.002, 0.008), unit(0.0, 1.0);
  CarvedField field = make_clay();
  for (int i = 0; i < 12; ++i) {
    const Vec3 from(coordinate(random), coordinate(random), coordinate(random));
    field.carve({from, from + Vec3(0.2 * coordinate(random), 0.2 * coordinate(random), 0), size(random)});
  }
  for (int i = 0; i < 150; ++i) {
    const Vec3 p(coordinate(random), coordinate(random), coordinate(random));
    const auto found = find_closest_surface_point(field, p);
    ASSERT_TRUE(found);
    const double ball_radius = (*found - p).norm() - 0.3 * kSpacingM;
    const bool is_inside = field.value(p) < 0.0;
    for (int k = 0; k < 300 && ball_radius > 0.0; ++k) {
      const Vec3 sample = p + ball_radius * std::cbrt(unit(random)) * random_direction(random);
      EXPECT_EQ(field.value(sample) < 0.0, is_inside) << p.transpose() << " at " << sample.transpose();
    }
  }
}

TEST(ClosestSurfacePoint, WhereNothingIsLeftThereIsNone) {
  CarvedField field = make_clay();
  field.carve({{0, 0, 0}, {0, 0, 0}, 2.0 * kBallRadiusM});
  EXPECT_FALSE(find_closest_surface_point(field, {0.01, 0, 0}));
}

}  // namespace
}  // namespace hapton
