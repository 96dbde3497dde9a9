#include "core/math/keyframe_motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

Quat about_z(double degrees) { return Quat(Eigen::AngleAxisd(degrees * std::numbers::pi / 180.0, Vec3::UnitZ())); }

const Vec3 kPivot(0.1, 0.2, 0.3);

// A quarter of a turn about the pivot in two seconds, then a second of rest, then 30 mm along x in three seconds.
KeyframeMotion quarter_and_shift(bool loops = false) {
  const Vec3 shifted = kPivot + Vec3(0.03, 0.0, 0.0);
  return {kPivot,
          {{0.0, kPivot, Quat::Identity()}, {2.0, kPivot, about_z(90)}, {3.0, kPivot, about_z(90)}, {6.0, shifted, about_z(90)}},
          loops};
}

TEST(KeyframeMotion, TurnsEvenlyAboutItsPivot) {
  const KeyframeMotion motion = quarter_and_shift();
  const Vec3 arm(0.05, 0.0, 0.01);
  for (const double time : {0.0, 0.25, 0.5, 1.0, 1.7, 2.0}) {
    const Vec3 expected = kPivot + about_z(45.0 * time) * arm;
    EXPECT_LT((motion.pose_at(time) * (kPivot + arm) - expected).norm(), 1e-15) << time;
    EXPECT_LT((motion.pose_at(time) * kPivot - kPivot).norm(), 1e-16) << time;
  }
}

TEST(KeyframeMotion, ShiftsStraightAndStaysAtItsEnds) {
  const KeyframeMotion motion = quarter_and_shift();
  EXPECT_LT((motion.pose_at(4.5) * kPivot - (kPivot + Vec3(0.015, 0, 0))).norm(), 1e-16);
  EXPECT_EQ(motion.pose_at(2.2).matrix(), motion.pose_at(2.9).matrix()) << "at rest to the last bit";
  EXPECT_EQ(motion.pose_at(6.0).matrix(), motion.pose_at(1e6).matrix());
  EXPECT_EQ(motion.pose_at(-3.0).matrix(), Pose::Identity().matrix());
  EXPECT_EQ(motion.duration_s(), 6.0);
}

TEST(KeyframeMotion, BeginsAgainWhereItLoops) {
  const KeyframeMotion there_and_back(kPivot,
                                      {{0.0, kPivot, Quat::Identity()}, {1.0, kPivot, about_z(60)}, {3.0, kPivot, Quat::Identity()}}, true);
  for (const double time : {0.0, 0.3, 1.0, 2.9}) {
    EXPECT_LT((there_and_back.pose_at(time + 300.0).matrix() - there_and_back.pose_at(time).matrix()).norm(), 1e-12) << time;
  }
}

TEST(KeyframeMotion, WaitsForItsFirstKeyframe) {
  const KeyframeMotion late(Vec3::Zero(), {{1.0, Vec3(0.01, 0, 0), Quat::Identity()}, {2.0, Vec3::Zero(), Quat::Identity()}}, false);
  EXPECT_EQ(late.pose_at(0.0).translation(), Vec3(0.01, 0, 0));
  EXPECT_EQ(late.pose_at(1.0).translation(), Vec3(0.01, 0, 0));
  EXPECT_EQ(late.pose_at(1.5).translation(), Vec3(0.005, 0, 0));
}

// -q is the same rotation as q.
TEST(KeyframeMotion, TurnsTheShorterWay) {
  Quat other = about_z(80);
  other.coeffs() = -other.coeffs();
  const KeyframeMotion motion(Vec3::Zero(), {{0.0, Vec3::Zero(), about_z(-80)}, {1.0, Vec3::Zero(), other}}, false);
  EXPECT_LT((motion.pose_at(0.5).linear() - Mat3::Identity()).norm(), 1e-12);
  EXPECT_LT((motion.pose_at(0.25).linear() - about_z(-40).toRotationMatrix()).norm(), 1e-12);
}

// A point at this radius, perpendicular to the axis, reaches the bound but never exceeds it.
TEST(KeyframeMotion, KnowsHowFastItIs) {
  const KeyframeMotion motion = quarter_and_shift();
  const double radius = 0.08;
  EXPECT_NEAR(motion.fastest_m_per_s(0, radius), 0.25 * std::numbers::pi * radius, 1e-12);
  EXPECT_EQ(motion.fastest_m_per_s(1, radius), 0.0);
  EXPECT_NEAR(motion.fastest_m_per_s(2, radius), 0.01, 1e-15);
  const double step = 1e-4;
  const Vec3 tip = kPivot + Vec3(0.0, radius, 0.0);
  for (double time = 0.1; time < 1.9; time += 0.1) {
    const double speed = (motion.pose_at(time + step) * tip - motion.pose_at(time) * tip).norm() / step;
    EXPECT_NEAR(speed, motion.fastest_m_per_s(0, radius), 1e-6);
    EXPECT_LE(speed, motion.fastest_m_per_s(0, radius) * (1.0 + 1e-9));
  }
}

TEST(KeyframeMotion, IsComparedByAllItsNumbers) {
  EXPECT_EQ(quarter_and_shift(), quarter_and_shift());
  EXPECT_NE(quarter_and_shift(false), quarter_and_shift(true));
  KeyframeMotion other = quarter_and_shift();
  auto keyframes = other.keyframes();
  keyframes[1].time_s = 2.5;
  EXPECT_NE(KeyframeMotion(kPivot, keyframes, false), other);
  EXPECT_NE(KeyframeMotion(Vec3::Zero(), other.keyframes(), false), other);
}

TEST(KeyframeMotion, IsFoundWithoutHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  const KeyframeMotion motion = quarter_and_shift(false);
  const AllocationGuard guard;
  double sum = 0.0;
  for (double time = 0.0; time < 7.0; time += 0.01) sum += motion.pose_at(time).translation().x();
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_TRUE(std::isfinite(sum));
}

}  // namespace
}  // namespace hapton
