#include <gtest/gtest.h>

#include "tests/safety/governor_bench.h"

namespace hapton {
namespace {

TEST(SafetyGovernor, AFaultOfAnEarlierRunStaysLatchedUntilTheReset) {
  Bench bench;
  bench.governor.restore_latched_fault(SafetyFault::jump);
  EXPECT_EQ(bench.press(2.0, 300), Vec3(0, 0, 0));
  EXPECT_EQ(bench.governor.state(), GovernorState::latched);
  EXPECT_EQ(bench.governor.fault(), SafetyFault::jump);
  EXPECT_EQ(bench.governor.counters().latched, 0U);
  EXPECT_TRUE(bench.governor.reset_faults());
  EXPECT_LT(bench.press(2.0, 1).z(), 0.05);
  EXPECT_EQ(bench.press(2.0, 150), Vec3(0, 0, 2.0));
}

TEST(SafetyGovernor, TimesOutWithoutSamplesOfTheDevice) {
  Bench bench;
  bench.press(4.0, 300);
  const std::int64_t last_sample_ns = bench.now_ns;
  for (int n = 0; n < 40; ++n) {
    bench.now_ns += kMs;
    bench.out = bench.governor.step(WrenchCommand{{Vec3(0, 0, 4), Vec3::Zero()}, bench.now_ns}, bench.now_ns);
    ASSERT_EQ(bench.governor.state() == GovernorState::pose_timeout, bench.now_ns - last_sample_ns >= 20 * kMs);
  }
  EXPECT_EQ(bench.out.force_n, Vec3::Zero());
  EXPECT_LT(bench.press(4.0, 20).z(), 1.0);
  EXPECT_EQ(bench.press(4.0, 100).z(), 4.0);

  SafetyGovernor without_samples(device_limits());
  for (std::int64_t now = 0; now < 300 * kMs; now += kMs) {
    ASSERT_EQ(without_samples.step(WrenchCommand{{Vec3(0, 0, 4), Vec3::Zero()}, now}, now).force_n, Vec3::Zero());
  }
}

TEST(SafetyGovernor, InvalidPosesAreIgnoredAndLatchWhenTheyRepeat) {
  Bench bench;
  bench.press(4.0, 300);
  const DeviceSample good = bench.sample;
  for (int n = 0; n < 4; ++n) {
    bench.sample.p_WD.y() = kNan;
    bench.press(4.0, 1);
    bench.sample = good;
    bench.press(4.0, 1);
  }
  EXPECT_EQ(bench.out.force_n, Vec3(0, 0, 4));
  EXPECT_EQ(bench.governor.counters().bad_samples, 4U);
  bench.sample.p_WD.y() = kInf;
  bench.press(4.0, 1);
  EXPECT_EQ(bench.governor.fault(), SafetyFault::position);
  EXPECT_EQ(bench.press(4.0, 10), Vec3::Zero());
}

TEST(SafetyGovernor, AJumpOfThePositionLatches) {
  Bench bench;
  bench.press(4.0, 300);
  bench.sample.p_WD.x() += 0.004;  // allowed: 2 mm by the speed limit, and 5 mm of tolerance
  bench.press(4.0, 1);
  EXPECT_EQ(bench.governor.fault(), SafetyFault::none);
  bench.sample.p_WD.x() += 0.0071;
  bench.press(4.0, 1);
  EXPECT_EQ(bench.governor.fault(), SafetyFault::jump);
  EXPECT_EQ(bench.press(4.0, 10), Vec3::Zero());
}

TEST(SafetyGovernor, AHandMayBeElsewhereAfterAGap) {
  Bench bench;
  bench.press(4.0, 300);
  bench.now_ns += 200 * kMs;
  bench.sample.p_WD.x() += 0.05;
  EXPECT_EQ(bench.press(4.0, 1), Vec3::Zero());
  EXPECT_EQ(bench.governor.fault(), SafetyFault::none);
  EXPECT_EQ(bench.press(4.0, 150), Vec3(0, 0, 4));
}

TEST(SafetyGovernor, AReleasedStylusGetsNoForceAndRampsBack) {
  Bench bench;
  bench.press(4.0, 300);
  bench.sample.is_held = false;
  EXPECT_EQ(bench.press(4.0, 10), Vec3::Zero());
  EXPECT_EQ(bench.governor.state(), GovernorState::switch_released);
  EXPECT_EQ(bench.governor.counters().releases, 1U);
  bench.sample.is_held = true;
  EXPECT_LT(bench.press(4.0, 20).z(), 1.0);
  EXPECT_EQ(bench.press(4.0, 100).z(), 4.0);
}

TEST(SafetyGovernor, AReleaseThatEndsWithinACycleIsFollowedByARampToo) {
  Bench bench;
  bench.press(4.0, 300);
  for (const bool is_held : {false, true}) {
    bench.now_ns += kMs / 4;
    bench.sample.time_ns = bench.now_ns;
    bench.sample.is_held = is_held;
    bench.governor.observe(bench.sample, bench.status);
  }
  EXPECT_LT(bench.press(4.0, 20).z(), 1.0);
  EXPECT_EQ(bench.press(4.0, 100).z(), 4.0);
}

TEST(SafetyGovernor, AButtonCanBeRequired) {
  Bench bench;
  bench.governor.require_button(2);
  bench.sample.buttons = 0b101;
  EXPECT_EQ(bench.press(4.0, 300), Vec3::Zero());
  bench.sample.buttons = 0b010;
  EXPECT_EQ(bench.press(4.0, 300).z(), 4.0);
  // A button can be required, but the requirement cannot be withdrawn.
  for (const int nonsense : {-1, 0, 33, 1000}) bench.governor.require_button(nonsense);
  bench.governor.require_button(3);
  EXPECT_EQ(bench.press(4.0, 300), Vec3::Zero());
  bench.sample.buttons = 0b110;
  EXPECT_EQ(bench.press(4.0, 300).z(), 4.0);
}

TEST(SafetyGovernor, ASwitchIsHeldOnlyWhileTheDeviceReportsIt) {
  Bench bench;
  bench.sample.buttons = 0b010;
  bench.press(4.0, 300);
  EXPECT_FALSE(bench.governor.is_switch_held()) << "no switch is required";
  bench.governor.require_button(2);
  bench.wait(1);
  EXPECT_TRUE(bench.governor.is_switch_held());
  // A device that is away repeats its last sample with its buttons.
  for (const DeviceStatus status : {DeviceStatus::away, DeviceStatus::calibrating, DeviceStatus::fault, DeviceStatus::ended}) {
    bench.status = status;
    bench.wait(1);
    EXPECT_FALSE(bench.governor.is_switch_held());
    bench.status = DeviceStatus::ready;
    bench.wait(1);
    EXPECT_TRUE(bench.governor.is_switch_held());
  }
  bench.sample.p_WD.x() = std::numeric_limits<double>::quiet_NaN();
  bench.wait(25);
  EXPECT_FALSE(bench.governor.is_switch_held());
  bench.sample.p_WD.x() = 0.0;
  bench.wait(1);
  EXPECT_TRUE(bench.governor.is_switch_held());
  bench.sample.buttons = 0;
  bench.wait(1);
  EXPECT_FALSE(bench.governor.is_switch_held());
}

TEST(SafetyGovernor, ADeviceAwayOrCalibratingGetsNoForceAndRampsOnReturn) {
  for (const DeviceStatus status : {DeviceStatus::away, DeviceStatus::calibrating}) {
    Bench bench;
    bench.press(4.0, 300);
    bench.status = status;
    EXPECT_EQ(bench.press(4.0, 10), Vec3::Zero());
    EXPECT_EQ(bench.governor.state(), status == DeviceStatus::away ? GovernorState::away : GovernorState::calibrating);
    bench.press(4.0, 500);
    bench.status = DeviceStatus::ready;
    bench.sample.p_WD = Vec3(0.08, -0.08, 0.01);  // not a jump, because the device was away
    EXPECT_LT(bench.press(4.0, 20).z(), 1.0);
    EXPECT_EQ(bench.press(4.0, 100).z(), 4.0);
    EXPECT_EQ(bench.governor.fault(), SafetyFault::none);
  }
}

TEST(SafetyGovernor, ADeviceThatFailedLatches) {
  Bench bench;
  bench.press(4.0, 300);
  bench.status = DeviceStatus::fault;
  EXPECT_EQ(bench.press(4.0, 10), Vec3::Zero());
  EXPECT_EQ(bench.governor.fault(), SafetyFault::device);
  EXPECT_FALSE(bench.governor.reset_faults());
  bench.status = DeviceStatus::ready;
  EXPECT_EQ(bench.press(4.0, 300), Vec3::Zero());
  EXPECT_TRUE(bench.governor.reset_faults());
  EXPECT_EQ(bench.press(4.0, 300).z(), 4.0);
}

TEST(SafetyGovernor, ALatchedFaultOutlivesEverythingButAResetAndThenRamps) {
  Bench bench;
  bench.press(4.0, 300);
  bench.sample.p_WD.x() = 0.05;
  bench.press(4.0, 1);
  ASSERT_EQ(bench.governor.fault(), SafetyFault::jump);
  EXPECT_EQ(bench.press(4.0, 10), Vec3::Zero());
  // Timeouts, other forces, absence, release, time: none of them is a reset.
  bench.wait(500);
  bench.press(8.0, 500);
  bench.status = DeviceStatus::away;
  bench.press(4.0, 100);
  bench.status = DeviceStatus::ready;
  bench.sample.is_held = false;
  bench.press(4.0, 100);
  bench.sample.is_held = true;
  bench.sample.buttons = ~0U;
  bench.press(4.0, 3000);
  bench.governor.tighten(device_limits());
  bench.now_ns += 3'600'000 * kMs;
  EXPECT_EQ(bench.press(4.0, 300), Vec3::Zero());
  EXPECT_EQ(bench.governor.fault(), SafetyFault::jump);
  EXPECT_EQ(bench.governor.state(), GovernorState::latched);
  EXPECT_TRUE(bench.governor.reset_faults());
  EXPECT_LT(bench.press(4.0, 20).z(), 1.0);
  EXPECT_EQ(bench.press(4.0, 100).z(), 4.0);
  EXPECT_EQ(bench.governor.counters().latched, 1U);
  EXPECT_EQ(bench.governor.counters().resets, 1U);
}

TEST(SafetyGovernor, NoResetWhileTheDeviceStillMovesTooFast) {
  Bench bench;
  bench.sample.p_WD.x() = -0.09;
  bench.press(1.0, 100);
  for (int n = 0; n < 30; ++n) {
    bench.sample.p_WD.x() += 0.0025;
    bench.press(1.0, 1);
  }
  ASSERT_EQ(bench.governor.fault(), SafetyFault::speed);
  EXPECT_FALSE(bench.governor.reset_faults());
  EXPECT_EQ(bench.governor.counters().resets_rejected, 1U);
  bench.press(1.0, 50);
  EXPECT_TRUE(bench.governor.reset_faults());
}

TEST(SafetyGovernor, TheFirstFaultIsReported) {
  Bench bench;
  bench.press(4.0, 300);
  bench.sample.p_WD.x() = 0.05;
  bench.press(4.0, 1);
  bench.status = DeviceStatus::fault;
  bench.press(4.0, 1);
  EXPECT_EQ(bench.governor.fault(), SafetyFault::jump);
  EXPECT_EQ(bench.governor.counters().latched, 1U);
}

TEST(SafetyGovernor, ATorqueRampsInAsAForceDoes) {
  DeviceLimits limits = device_limits();
  limits.max_torque_slew_nm_per_s = 1e6;
  Bench bench(limits);
  for (int n = 1; n <= 50; ++n) {
    bench.cycle(Wrench{Vec3(0, 0, 4), Vec3(0.4, 0, 0)});
    ASSERT_NEAR(bench.out.torque_nm.x() / 0.4, bench.out.force_n.z() / 4.0, 1e-9) << n;
  }
  EXPECT_LT(bench.out.torque_nm.x(), 0.3);
}

TEST(SafetyGovernor, NoResetWhileTheDeviceIsSoFastThatItIsBraked) {
  Bench bench;
  bench.sample.p_WD.z() = -0.09;
  bench.governor.restore_latched_fault(SafetyFault::jump);
  move_along_z(bench, 1.5, 50);  // the limit is 2 m/s; above 1.2 m/s the device is braked
  ASSERT_EQ(bench.governor.fault(), SafetyFault::jump);
  EXPECT_FALSE(bench.governor.reset_faults());
  move_along_z(bench, 0.5, 40);
  EXPECT_TRUE(bench.governor.reset_faults());
}

}  // namespace
}  // namespace hapton
