#include "safety/motion_monitor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>

#include "safety/fault_debouncer.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

DeviceSample sample_at(const Vec3& p) {
  DeviceSample sample;
  sample.p_WD = p;
  return sample;
}

TEST(MotionMonitor, FindsTheVelocityBehindTheStepsOfAnEncoder) {
  constexpr double kStepM = 0.0254 / 800.0;
  for (const double rate_hz : {250.0, 1000.0, 10'000.0}) {
    MotionMonitor motion;
    double max_speed_m_per_s = 0.0;
    for (int n = 0; n < static_cast<int>(rate_hz); ++n) {
      const double t_s = n / rate_hz;
      const auto time_ns = static_cast<std::int64_t>(1e9 * t_s);
      ASSERT_EQ(motion.update(sample_at(Vec3(std::round(0.2 * t_s / kStepM) * kStepM, 0, 0)), time_ns, 3.0, false),
                MotionMonitor::Verdict::fine);
      max_speed_m_per_s = std::max(max_speed_m_per_s, motion.speed_m_per_s());
    }
    EXPECT_NEAR(motion.velocity_m_per_s().x(), 0.2, 0.02) << rate_hz;
    EXPECT_LT(max_speed_m_per_s, 0.22) << rate_hz;
  }
}

TEST(MotionMonitor, TwoReadsAtOnceAreNoSpeed) {
  MotionMonitor motion;
  motion.update(sample_at(Vec3::Zero()), 0, 3.0, false);
  EXPECT_EQ(motion.update(sample_at(Vec3(3e-5, 0, 0)), 10, 3.0, false), MotionMonitor::Verdict::fine);
  EXPECT_LT(motion.speed_m_per_s(), 0.01);
}

TEST(MotionMonitor, LeavesOutInvalidPoses) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  MotionMonitor motion;
  motion.update(sample_at(Vec3(0.01, 0, 0)), 0, 3.0, false);
  for (const double bad : {kNan, std::numeric_limits<double>::infinity(), 1e300, -1e7}) {
    EXPECT_EQ(motion.update(sample_at(Vec3(0, bad, 0)), kMs, 3.0, false), MotionMonitor::Verdict::invalid_pose);
  }
  for (const Quat& bad : {Quat(0, 0, 0, 0), Quat(2, 0, 0, 0), Quat(kNan, 0, 0, 0)}) {
    DeviceSample sample = sample_at(Vec3(0.01, 0, 0));
    sample.q_WT = bad;
    EXPECT_EQ(motion.update(sample, kMs, 3.0, false), MotionMonitor::Verdict::invalid_pose);
  }
  EXPECT_EQ(motion.p_WD(), Vec3(0.01, 0, 0));
  EXPECT_EQ(motion.moved_m(), Vec3::Zero());
  EXPECT_FALSE(motion.is_current(20 * kMs));
  EXPECT_TRUE(motion.is_current(19 * kMs));
}

TEST(MotionMonitor, ATurnIsAJumpOnlyWhereMotorsTurn) {
  for (const bool has_torque : {false, true}) {
    MotionMonitor motion;
    motion.update(sample_at(Vec3::Zero()), 0, 3.0, has_torque);
    DeviceSample sample;
    sample.q_WT = Quat(Eigen::AngleAxisd(0.2, Vec3::UnitX()));
    EXPECT_EQ(motion.update(sample, kMs, 3.0, has_torque), MotionMonitor::Verdict::fine);
    EXPECT_NEAR(motion.turned_rad().x(), has_torque ? 0.2 : 0.0, 1e-3);
    sample.q_WT = Quat(Eigen::AngleAxisd(1.2, Vec3::UnitX()));
    EXPECT_EQ(motion.update(sample, 2 * kMs, 3.0, has_torque), has_torque ? MotionMonitor::Verdict::jump : MotionMonitor::Verdict::fine);
  }
}

TEST(MotionMonitor, QAndItsNegativeAreOneRotation) {
  MotionMonitor motion;
  motion.update(sample_at(Vec3::Zero()), 0, 3.0, true);
  DeviceSample sample;
  sample.q_WT.coeffs() *= -1.0;
  EXPECT_EQ(motion.update(sample, kMs, 3.0, true), MotionMonitor::Verdict::fine);
  EXPECT_LT(motion.turned_rad().norm(), 1e-12);
  for (const double sign : {1.0, -1.0}) {
    const Vec3 before = sample.q_WT.vec();
    sample.q_WT = Quat(Eigen::AngleAxisd(before.norm() < 1e-3 ? 0.2 : 0.4, Vec3::UnitX()));
    sample.q_WT.coeffs() *= sign;
    EXPECT_EQ(motion.update(sample, (sign > 0.0 ? 20 : 40) * kMs, 3.0, true), MotionMonitor::Verdict::fine);
    EXPECT_NEAR(motion.turned_rad().x(), 0.2, 1e-3) << sign;
  }
}

TEST(MotionMonitor, WhatWasForgottenIsNoJump) {
  MotionMonitor motion;
  motion.update(sample_at(Vec3::Zero()), 0, 3.0, false);
  motion.forget();
  EXPECT_FALSE(motion.is_current(0));
  EXPECT_EQ(motion.update(sample_at(Vec3(1, 0, 0)), kMs, 3.0, false), MotionMonitor::Verdict::fine);
  EXPECT_EQ(motion.moved_m(), Vec3::Zero());
  EXPECT_EQ(motion.update(sample_at(Vec3(0.9, 0, 0)), 2 * kMs, 3.0, false), MotionMonitor::Verdict::jump);
}

// The rest of an earlier velocity would be damped, which would be a force on a hand that stands still.
TEST(MotionMonitor, IsAtRestAfterAJumpAndAfterItForgot) {
  const auto moving = [] {
    MotionMonitor motion;
    for (int n = 0; n < 100; ++n) motion.update(sample_at(Vec3(1e-3 * n, 0, 0)), n * kMs, 3.0, false);
    EXPECT_GT(motion.speed_m_per_s(), 0.9);
    return motion;
  };
  MotionMonitor jumps = moving();
  EXPECT_EQ(jumps.update(sample_at(Vec3(-1, 0, 0)), 100 * kMs, 3.0, false), MotionMonitor::Verdict::jump);
  EXPECT_EQ(jumps.speed_m_per_s(), 0.0);
  EXPECT_EQ(jumps.velocity_m_per_s(), Vec3::Zero());
  MotionMonitor forgets = moving();
  forgets.forget();
  EXPECT_EQ(forgets.update(sample_at(Vec3(0.1, 0, 0)), 100 * kMs, 3.0, false), MotionMonitor::Verdict::fine);
  EXPECT_EQ(forgets.speed_m_per_s(), 0.0);
  EXPECT_EQ(forgets.velocity_m_per_s(), Vec3::Zero());
}

// A tenth of a second without a sample: the hand may have moved anywhere meanwhile.
TEST(MotionMonitor, AGapBeginsAtATenthOfASecond) {
  for (const auto& [gap_ns, expected] :
       {std::pair{100 * kMs - 1, MotionMonitor::Verdict::jump}, {100 * kMs, MotionMonitor::Verdict::fine}}) {
    MotionMonitor motion;
    motion.update(sample_at(Vec3::Zero()), 0, 3.0, false);
    EXPECT_EQ(motion.update(sample_at(Vec3(1, 0, 0)), gap_ns, 3.0, false), expected) << gap_ns;
  }
}

// The limit is 50 rad/s plus 0.2 rad. Where no torque is exerted, a stylus may turn as it likes.
TEST(MotionMonitor, ATurnFasterThanAnyHandIsAJump) {
  for (const auto& [turn_rad, expected] : {std::pair{0.69, MotionMonitor::Verdict::fine}, {0.74, MotionMonitor::Verdict::jump}}) {
    for (const double sign : {1.0, -1.0}) {
      DeviceSample turned = sample_at(Vec3::Zero());
      turned.q_WT = Quat(Eigen::AngleAxisd(sign * turn_rad, Vec3(1, 2, 2) / 3.0));
      MotionMonitor motion;
      motion.update(sample_at(Vec3::Zero()), 0, 3.0, true);
      EXPECT_EQ(motion.update(turned, 10 * kMs, 3.0, true), expected) << sign * turn_rad;
      MotionMonitor without_torque;
      without_torque.update(sample_at(Vec3::Zero()), 0, 3.0, false);
      EXPECT_EQ(without_torque.update(turned, 10 * kMs, 3.0, false), MotionMonitor::Verdict::fine);
    }
  }
}

TEST(FaultDebouncer, FiveAreTooManyUnlessTheyAreForgottenMeanwhile) {
  FaultDebouncer fault_debouncer;
  for (int n = 0; n < 4; ++n) EXPECT_FALSE(fault_debouncer.note(n * 90 * kMs));
  EXPECT_FALSE(fault_debouncer.note(360 * kMs));  // the first three are forgotten
  FaultDebouncer quick;
  for (int n = 0; n < 4; ++n) EXPECT_FALSE(quick.note(n * 20 * kMs));
  EXPECT_TRUE(quick.note(80 * kMs));
  quick.clear();
  EXPECT_FALSE(quick.note(90 * kMs));
}

TEST(FaultDebouncer, FaultsFarApartAreNeverTooMany) {
  FaultDebouncer fault_debouncer;
  for (std::int64_t n = 0; n < 1000; ++n) ASSERT_FALSE(fault_debouncer.note(n * 101 * kMs));
}

}  // namespace
}  // namespace hapton
