#include "core/collision/swept_sphere.h"

#include <gtest/gtest.h>

#include <random>

namespace hapton {
namespace {

TriangleMesh one_triangle(const Vec3& a, const Vec3& b, const Vec3& c) { return {{a, b, c}, {{0, 1, 2}}}; }

constexpr int kMotionSamples = 20000;

// The smallest distance, and the first time at which it is `level` or less, among samples of the motion.
struct SampledDistances {
  double first_time = kNever;
  double least_distance = std::numeric_limits<double>::infinity();
};
SampledDistances sample_distances(const TouchGeometry& geometry, const Vec3& p, const Vec3& motion, double level) {
  SampledDistances sampled;
  for (int i = 0; i <= kMotionSamples; ++i) {
    const double t = static_cast<double>(i) / kMotionSamples;
    const double d = geometry.separation(0, p + t * motion).distance;
    sampled.least_distance = std::min(sampled.least_distance, d);
    if (d <= level && sampled.first_time > 1.0) sampled.first_time = t;
  }
  return sampled;
}

class SweptSphere : public testing::TestWithParam<double> {};

TEST_P(SweptSphere, BlocksWhereSamplesOfTheMotionDo) {
  const Clearance clearance{.offset = GetParam(), .slop = 0.5 * GetParam(), .tolerance = 1e-3 * GetParam()};
  constexpr unsigned kSeed = 77;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> coordinate(-0.5, 0.5);
  const auto point = [&] { return Vec3(coordinate(random), coordinate(random), coordinate(random)); };
  int blocked = 0;
  for (int i = 0; i < 200; ++i) {
    const TriangleMesh mesh = one_triangle(point(), point(), point());
    const TouchGeometry geometry({&mesh});
    const Vec3 p = 2.0 * point();
    const Vec3 aim = i % 2 == 0 ? geometry.corner(0, i % 3) : Vec3(0.4 * geometry.corner(0, 0) + 0.6 * geometry.corner(0, 1));
    const Vec3 motion = 1.5 * (aim + 0.2 * point() - p);
    if (geometry.separation(0, p).distance <= clearance.offset) continue;
    const double t = time_to_block(TriangleView{geometry, 0}, p, motion, 1.0, clearance);
    const SampledDistances sampled = sample_distances(geometry, p, motion, clearance.offset);
    const double sample_spacing = motion.norm() / kMotionSamples;
    if (sampled.least_distance < clearance.offset - clearance.slop) {
      EXPECT_LE(t, 1.0) << "case " << i << " went through";
    }
    if (sampled.least_distance > clearance.offset + sample_spacing) {
      EXPECT_GT(t, 1.0) << "case " << i << " was blocked by nothing";
    }
    if (t > 1.0) continue;
    ++blocked;
    EXPECT_LE(t, sampled.first_time + 1e-9) << "case " << i << " stopped too late";
    EXPECT_NEAR(geometry.separation(0, p + t * motion).distance, clearance.offset, 2.0 * clearance.tolerance);
  }
  EXPECT_GT(blocked, 10);
}

INSTANTIATE_TEST_SUITE_P(Radii, SweptSphere, testing::Values(1e-2, 0.1, 0.3));

TEST(SweptSpherePoint, APointProbeNeverPassesAFaceEdgeOrCorner) {
  const double contact_offset = 0x1p-30;
  const Clearance clearance{.offset = contact_offset, .slop = 0.5 * contact_offset, .tolerance = 0x1p-10 * contact_offset};
  const TriangleMesh mesh = one_triangle({-0.5, -0.5, 0}, {0.5, -0.5, 0}, {0, 0.5, 0});
  const TouchGeometry geometry({&mesh});
  const auto time_down_to = [&](const Vec3& at) {
    const Vec3 target = geometry.to_local(at);
    return time_to_block(TriangleView{geometry, 0}, target + Vec3(0, 0, 0.25), Vec3(0, 0, -0.5), 1.0, clearance);
  };
  EXPECT_LE(time_down_to({0, 0, 0}), 0.5);
  EXPECT_LE(time_down_to({0, -0.5, 0}), 0.5);
  EXPECT_LE(time_down_to({0.5, -0.5, 0}), 0.5);
  EXPECT_GT(time_down_to({0, -0.5 - 1e-6, 0}), 1.0);
}

TEST(SweptSpherePoint, MovingAlongOrAwayIsNeverBlocked) {
  const double contact_offset = 0x1p-30;
  const Clearance clearance{.offset = contact_offset, .slop = 0.5 * contact_offset, .tolerance = 0x1p-10 * contact_offset};
  const TriangleMesh mesh = one_triangle({-0.5, -0.5, 0}, {0.5, -0.5, 0}, {0, 0.5, 0});
  const TouchGeometry geometry({&mesh});
  const Vec3 resting = geometry.to_local({0, 0, 0}) + Vec3(0, 0, contact_offset);
  EXPECT_GT(time_to_block(TriangleView{geometry, 0}, resting, Vec3(0.1, 0.05, 0), 1.0, clearance), 1.0);
  EXPECT_GT(time_to_block(TriangleView{geometry, 0}, resting, Vec3(0.1, 0, 0.2), 1.0, clearance), 1.0);
  EXPECT_LE(time_to_block(TriangleView{geometry, 0}, resting, Vec3(0.1, 0, -0.2), 1.0, clearance), 1e-6);
}

TEST(SweptSpherePoint, AShallowConcaveEdgeBlocksByItsFace) {
  // The probe moves on a first face, which is not in the mesh, over the shared edge onto a second one that rises by 0.1 degree.
  const double rise = 0.5 * 0.00175;  // over 0.5 at the tangent of 0.1 degree
  const TriangleMesh second = one_triangle({0, -0.5, 0}, {0.5, 0, rise}, {0, 0.5, 0});
  const TouchGeometry geometry({&second});
  const double contact_offset = 0x1p-30;
  const Clearance clearance{.offset = contact_offset, .slop = 0.5 * contact_offset, .tolerance = 0x1p-10 * contact_offset};
  const Vec3 edge = geometry.to_local({0, 0, 0});
  const Vec3 start = edge + Vec3(-0.1, 0, contact_offset);
  const Vec3 motion(0.2, 0, 0);
  const double t = time_to_block(TriangleView{geometry, 0}, start, motion, 1.0, clearance);
  ASSERT_LE(t, 1.0);
  const Separation blocks = blocking_separation(TriangleView{geometry, 0}, start + t * motion, (1.0 - t) * motion, clearance);
  EXPECT_EQ(blocks.feature, Feature::face);
  EXPECT_LT(blocks.normal.dot(motion), 0.0);
}

TEST(ComesNearer, AgreesWithSamplesOfTheMotion) {
  constexpr unsigned kSeed = 78;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> coordinate(-0.5, 0.5);
  const auto point = [&] { return Vec3(coordinate(random), coordinate(random), coordinate(random)); };
  int nearer_count = 0;
  for (int i = 0; i < 200; ++i) {
    const TriangleMesh mesh = one_triangle(point(), point(), point());
    const TouchGeometry geometry({&mesh});
    const Vec3 p = point();
    const Vec3 motion = point();
    const double end_distance = std::min(geometry.separation(0, p).distance, geometry.separation(0, p + motion).distance);
    const SampledDistances sampled = sample_distances(geometry, p, motion, 0.0);
    for (const double level : {end_distance, 0.5 * (end_distance + sampled.least_distance), 0.999 * sampled.least_distance}) {
      constexpr double kTolerance = 1e-9;
      const bool found = comes_nearer(TriangleView{geometry, 0}, p, motion, 0.0, 1.0, level, kTolerance);
      if (sampled.least_distance < level - 1e-6) {
        EXPECT_TRUE(found) << "case " << i << " level " << level;
      }
      if (sampled.least_distance > level + 1e-4) {
        EXPECT_FALSE(found) << "case " << i << " level " << level;
      }
      nearer_count += found ? 1 : 0;
    }
  }
  EXPECT_GT(nearer_count, 50);
}

// At the contact offset from an edge, the direction of a tangent has a rounding error, which over a long way grows to many contact offsets.
TEST(ComesNearer, ALongSlideAlongAnEdgePasses) {
  constexpr double kContactOffset = 0x1p-30;
  const TriangleMesh mesh = one_triangle({0.1, -0.3, 0.0}, {0.37, 0.41, 0.0}, {0.5, -0.2, 0.0});
  const TouchGeometry geometry({&mesh});
  const Vec3& a = geometry.corner(0, 0);
  const Vec3 edge = geometry.corner(0, 1) - a;
  const Vec3 away = Vec3(-edge.y(), edge.x(), 0.0).normalized();
  const Vec3 p = a + 0.1 * edge + 0.75 * kContactOffset * away;
  const Clearance clearance{.offset = kContactOffset, .slop = 0.5 * kContactOffset, .tolerance = 0x1p-10 * kContactOffset};
  EXPECT_GT(time_to_block(TriangleView{geometry, 0}, p, 0.8 * edge, 1.0, clearance), 1.0);
  EXPECT_LE(time_to_block(TriangleView{geometry, 0}, p, 0.8 * edge - 2.0 * kContactOffset * away, 1.0, clearance), 1.0);
}

}  // namespace
}  // namespace hapton
