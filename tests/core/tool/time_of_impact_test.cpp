#include "core/tool/time_of_impact.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/core/tool/feature_pair_fixture.h"

namespace hapton {
namespace {

using TimeOfImpact = FeaturePairTest;

// True if the edges may become so nearly parallel that bound_time_of_impact leaves them to the pairs of their ends.
bool is_too_parallel(const FeaturePair& pair, const RigidMotion& motion, double floor) {
  const Vec3 d = motion.from.orientation * (pair.tool[1] - pair.tool[0]);
  const Vec3 e = pair.scene[1] - pair.scene[0];
  const double sine = d.normalized().cross(e.normalized()).norm();
  return std::min(d.norm(), e.norm()) * (sine + motion.turn.norm()) <= 0.26 * floor;
}

// Dense samples of the motion stay above the floor until the bound. The bound is 1 for most motions that stay above it to the end.
TEST_F(TimeOfImpact, NoMotionComesBelowItsFloorBeforeTheBound) {
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  int clear_motions = 0;
  int clear_to_the_end = 0;
  int shortened_motions = 0;
  for (int n = 0; n < 6000; ++n) {
    const FeaturePair pair = draw_pair(kKinds[n % 3]);
    const RigidMotion motion{draw_placement(), draw(0.2), draw(n % 2 == 0 ? 0.5 : 0.02)};
    const FeatureGap gap = measure_gap(pair, motion.from);
    const double floor = gap.distance * (0.05 + 0.9 * std::abs(uniform(random)));
    if (pair.kind == Kind::edge_edge && is_too_parallel(pair, motion, floor)) continue;
    const double time = bound_time_of_impact(pair, gap, motion, floor, 1.0);
    ASSERT_GE(time, 0.0);
    ASSERT_LE(time, 1.0);
    double least = gap.distance;
    for (int i = 0; i <= 50; ++i) {
      const double distance = measure_gap(pair, motion.at(time * i / 50.0)).distance;
      ASSERT_GE(distance, floor * (1.0 - 1e-6)) << "case " << n << " kind " << static_cast<int>(pair.kind) << " at " << i / 50.0;
    }
    for (int i = 0; i <= 200; ++i) least = std::min(least, measure_gap(pair, motion.at(i / 200.0)).distance);
    if (least > 1.01 * floor) {
      ++clear_motions;
      clear_to_the_end += time >= 1.0 ? 1 : 0;
    } else {
      shortened_motions += time < 1.0 ? 1 : 0;
    }
  }
  EXPECT_GT(shortened_motions, 500);
  EXPECT_GT(clear_to_the_end, clear_motions * 98 / 100) << "of " << clear_motions;
}

TEST_F(TimeOfImpact, ParallelEdgesAreLeftToTheirEnds) {
  FeaturePair pair;
  pair.kind = Kind::edge_edge;
  pair.tool = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3::Zero()};
  pair.scene = {Vec3(0.5, 0, -1e-6), Vec3(1.5, 0, -1e-6), Vec3::Zero()};
  const RigidMotion motion{{}, {0.0, 1e-3, 0.0}, Vec3::Zero()};
  EXPECT_EQ(bound_time_of_impact(pair, measure_gap(pair, motion.from), motion, 7.5e-7, 1.0), 1.0);
}

// A vertex circles above a face: every advance has the same length, because the bound does not know that it never comes nearer.
TEST_F(TimeOfImpact, TheSearchEndsAfterTheLargestNumberOfAdvancesOrAfterAShortOne) {
  constexpr double kFloor = 5e-6;
  const RigidMotion motion{{}, Vec3::Zero(), {0.0, 0.0, 0.5}};
  const auto time_for = [&](double advance_share) {
    const double height = kFloor + 0.5 * advance_share * advance_share * motion.turn.squaredNorm() * 0.1;
    FeaturePair pair;
    pair.kind = Kind::vertex_face;
    pair.tool = {Vec3(0.1, 0.0, height), Vec3::Zero(), Vec3::Zero()};
    pair.scene = {Vec3(-1, -1, 0), Vec3(1, -1, 0), Vec3(0, 1, 0)};
    return bound_time_of_impact(pair, measure_gap(pair, motion.from), motion, kFloor, 1.0);
  };
  EXPECT_NEAR(time_for(0.02), kMaxAdvances * 0.02, 1e-6);
  EXPECT_NEAR(time_for(1.1 * 0x1p-12), kMaxAdvances * 1.1 * 0x1p-12, 1e-6);
  EXPECT_NEAR(time_for(0.9 * 0x1p-12), 2 * 0.9 * 0x1p-12, 1e-6);
  EXPECT_EQ(time_for(0.04), 1.0);
}

}  // namespace
}  // namespace hapton
