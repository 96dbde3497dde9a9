#include "safety/speed_limit.h"

#include <gtest/gtest.h>

#include "tests/support/time_units.h"

namespace hapton {
namespace {

const DeviceLimits kSpeedLimits = {.max_force_n = 8.0, .max_speed_m_per_s = 2.0};
constexpr double kDamping = 0.5;  // Ns/m

// A device that has moved along x at this speed for a while.
MotionMonitor moving_at(double speed_m_per_s) {
  MotionMonitor motion;
  DeviceSample sample;
  for (int n = 0; n < 300; ++n) {
    sample.p_WD.x() = 1e-3 * speed_m_per_s * n;
    motion.update(sample, n * kMs, 3.0, false);
  }
  EXPECT_NEAR(motion.speed_m_per_s(), speed_m_per_s, 1e-9);
  return motion;
}

TEST(SpeedLimit, BelowTheSoftLimitTheForceStays) {
  const Vec3 force_n(3.0, -2.0, 1.0);
  EXPECT_EQ(SpeedLimit::limit_force(kSpeedLimits, kDamping, force_n, moving_at(1.1)), force_n);
  EXPECT_FALSE(SpeedLimit::is_soft(kSpeedLimits, 1.2));
  EXPECT_TRUE(SpeedLimit::is_soft(kSpeedLimits, 1.21));
}

// 1.6 m/s is half way between 0.6 of the limit and the limit: half of the pushing part is removed, and half of the damping is added.
TEST(SpeedLimit, TakesAwayWhatPushesAlongTheMotionAndNothingElse) {
  const MotionMonitor motion = moving_at(1.6);
  const Vec3 damping_n(-0.5 * kDamping * 1.6, 0.0, 0.0);
  EXPECT_LT((SpeedLimit::limit_force(kSpeedLimits, kDamping, Vec3(4.0, 1.0, 0.0), motion) - Vec3(2.0, 1.0, 0.0) - damping_n).norm(), 1e-9);
  EXPECT_LT((SpeedLimit::limit_force(kSpeedLimits, kDamping, Vec3(-4.0, 1.0, 0.0), motion) - Vec3(-4.0, 1.0, 0.0) - damping_n).norm(), 1e-9)
      << "what slows the device down stays";
}

TEST(SpeedLimit, AtTheLimitNothingPushesAndItIsExceeded) {
  const Vec3 limited_n = SpeedLimit::limit_force(kSpeedLimits, kDamping, Vec3(8.0, 0.0, 2.0), moving_at(2.0));
  EXPECT_LT((limited_n - Vec3(-kDamping * 2.0, 0.0, 2.0)).norm(), 1e-9);
  EXPECT_TRUE(SpeedLimit::is_exceeded(kSpeedLimits, 2.0));
  EXPECT_FALSE(SpeedLimit::is_exceeded(kSpeedLimits, 1.999));
}

}  // namespace
}  // namespace hapton
