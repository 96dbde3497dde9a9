#include <gtest/gtest.h>

#include "tests/safety/governor_bench.h"

namespace hapton {
namespace {

TEST(SafetyGovernor, AForceThatAcceleratesAFastDeviceFadesToDamping) {
  double before = 1.0;
  for (const double speed : {1.0, 1.3, 1.5, 1.7, 1.9}) {
    Bench bench;
    bench.sample.p_WD.z() = -0.09;
    bench.press(1.0, 200);
    move_along_z(bench, speed, 50);
    EXPECT_EQ(bench.governor.fault(), SafetyFault::none);
    EXPECT_EQ(bench.governor.counters().speed_limited > 0, speed > 1.2);
    if (speed > 1.2) {
      EXPECT_LT(bench.out.force_n.z(), before - 0.1) << speed;
    } else {
      EXPECT_EQ(bench.out.force_n.z(), 1.0);
    }
    before = bench.out.force_n.z();
  }
  EXPECT_LT(before, -2.0);
}

TEST(SafetyGovernor, ASoftDeviceIsDampedNoMoreThanItsStiffnessBears) {
  DeviceLimits limits = device_limits();
  limits.max_stiffness_n_per_m = 0.5;
  Bench bench(limits);
  bench.sample.p_WD.z() = -0.09;
  bench.press(1.0, 200);
  move_along_z(bench, 1.9, 50);
  EXPECT_GT(bench.governor.counters().speed_limited, 0U);
  EXPECT_GT(bench.out.force_n.z(), -0.01) << "2 ms of 0.5 N/m, at 2 m/s";
}

TEST(SafetyGovernor, ADeviceFasterThanItsLimitLatches) {
  Bench bench;
  bench.sample.p_WD.z() = -0.09;
  bench.press(1.0, 200);
  move_along_z(bench, 2.5, 30);
  EXPECT_EQ(bench.governor.fault(), SafetyFault::speed);
  EXPECT_EQ(bench.press(1.0, 10), Vec3::Zero());
}

TEST(SafetyGovernor, EnergyGivenBeyondWhatIsFreeIsDampedAgainstTheMotion) {
  Bench bench;
  bench.sample.p_WD.x() = -0.08;
  const auto move = [&](const Vec3& force_n, int cycles) {
    for (int n = 0; n < cycles; ++n) {
      bench.sample.p_WD.x() += 1e-4;
      bench.cycle(Wrench{force_n, Vec3::Zero()});
    }
  };
  move(Vec3(4, 0, 0), 150);
  EXPECT_EQ(bench.out.force_n, Vec3(4, 0, 0));
  move(Vec3(0, 0, 4), 50);
  EXPECT_EQ(bench.out.force_n, Vec3(0, 0, 4));  // up to the free energy, nothing changes
  EXPECT_EQ(bench.governor.counters().damped, 0U);
  move(Vec3(4, 0, 0), 200);
  ASSERT_GT(bench.governor.energy_spent_j(), EnergyBudget::free_j(8.0));
  move(Vec3(0, 0, 4), 10);
  EXPECT_NEAR(bench.out.force_n.x(), -0.1 * bench.governor.most_damping_n_s_per_m(), 0.01);
  EXPECT_NEAR(bench.out.force_n.z(), 4.0, 1e-9);
  const double spent_j = bench.governor.energy_spent_j();
  move(Vec3(0, 0, 4), 50);
  EXPECT_LT(bench.governor.energy_spent_j(), spent_j - 1e-4);
}

// At rest nothing is damped: a force counts as damped if it is above the limit, which has fallen with the energy spent.
TEST(SafetyGovernor, AFadedLimitCountsAsDampedOnlyWhereItIsReached) {
  Bench bench;
  bench.sample.p_WD.x() = -0.08;
  EXPECT_FALSE(bench.governor.is_energy_gone());
  bench.press(0.0, 200);
  for (int n = 0; n < 200; ++n) {
    bench.sample.p_WD.x() += 2e-4;
    bench.cycle(Wrench{Vec3(8, 0, 0), Vec3::Zero()});
  }
  // After a while without samples, the velocity is not known and counts as zero.
  bench.now_ns += 300 * kMs;
  bench.press(0.0, 200);
  ASSERT_EQ(bench.governor.speed_m_per_s(), 0.0);
  const double spent_j = bench.governor.energy_spent_j();
  const double share = (EnergyBudget::most_j(8.0) - spent_j) / (EnergyBudget::most_j(8.0) - EnergyBudget::free_j(8.0));
  ASSERT_GT(share, 0.2);
  ASSERT_LT(share, 0.95);
  EXPECT_FALSE(bench.governor.is_energy_gone());
  const std::uint64_t before = bench.governor.counters().damped;
  bench.press(0.1, 5);
  EXPECT_EQ(bench.governor.counters().damped, before) << "a force far below the limit";
  bench.press(8.0, 5);
  EXPECT_EQ(bench.governor.counters().damped, before + 5);
}

// An accepted force counts once for each way in which it was limited.
TEST(SafetyGovernor, EachForceIsCountedOnce) {
  Bench stopped;
  stopped.sample.p_WD.z() = 0.15;
  stopped.press(4.0, 300);
  const GovernorCounters before = stopped.governor.counters();
  stopped.press(4.0, 7);
  EXPECT_EQ(stopped.governor.counters().workspace_limited, before.workspace_limited + 7);
  EXPECT_EQ(stopped.governor.counters().clamped, before.clamped);
  EXPECT_EQ(stopped.governor.counters().rate_limited, before.rate_limited);
  stopped.press(9.0, 3);
  EXPECT_EQ(stopped.governor.counters().clamped, before.clamped + 3);
  EXPECT_EQ(stopped.governor.counters().workspace_limited, before.workspace_limited + 10);

  Bench braked;
  braked.sample.p_WD.z() = -0.09;
  braked.press(1.0, 200);
  move_along_z(braked, 1.7, 30);
  const std::uint64_t limited_before = braked.governor.counters().speed_limited;
  move_along_z(braked, 1.7, 7);
  EXPECT_EQ(braked.governor.counters().speed_limited, limited_before + 7);

  Bench slewed;
  slewed.press(-7.5, 300);
  ASSERT_EQ(slewed.governor.counters().rate_limited, 0U);
  slewed.press(7.5, 5);  // the slew limit allows 2 N in a cycle of 1 ms, so 15 N take eight cycles
  EXPECT_EQ(slewed.governor.counters().rate_limited, 5U);
  slewed.press(7.5, 5);
  EXPECT_EQ(slewed.governor.counters().rate_limited, 7U) << "the eighth cycle reaches the force";
}

// The device moves where the force pushes it: all of the work would be energy that nobody put in.
TEST(SafetyGovernor, EachForceThatPassivityLimitsIsCountedOnce) {
  Bench bench;
  bench.governor.keep_passive({.mass_kg = 0.1, .damping_ns_per_m = 0.0, .friction_n = 0.0});
  bench.sample.p_WD.z() = -0.09;
  move_along_z(bench, 0.1, 300);
  const GovernorCounters before = bench.governor.counters();
  ASSERT_GT(before.kept_passive, 0U);
  move_along_z(bench, 0.1, 9);
  EXPECT_EQ(bench.governor.counters().kept_passive, before.kept_passive + 9);
  EXPECT_EQ(bench.governor.counters().clamped, 0U);
  bench.wait(5);
  EXPECT_EQ(bench.governor.counters().kept_passive, before.kept_passive + 9) << "no force came";
  bench.press(0.0, 5);
  EXPECT_EQ(bench.governor.counters().kept_passive, before.kept_passive + 9) << "there is nothing to limit";
}

TEST(SafetyGovernor, AfterAnInterruptNothingComesBeforeANewCommand) {
  Bench bench;
  bench.press(5.0, 200);
  ASSERT_EQ(bench.out.force_n, Vec3(0, 0, 5));
  bench.governor.interrupt();
  EXPECT_TRUE(bench.governor.has_timed_out());
  bench.wait(5);
  EXPECT_EQ(bench.out.force_n, Vec3::Zero());
  EXPECT_EQ(bench.governor.state(), GovernorState::no_command);
  EXPECT_LT(bench.press(5.0, 1).z(), 1.0) << "it ramps up again";
}

TEST(SafetyGovernor, TheEndOfTheWorkspaceRemovesOutwardForceAndAddsNothing) {
  Bench bench;
  const auto press_at = [&](double z, double force_n) {
    bench.now_ns += 200 * kMs;
    bench.sample.p_WD.z() = z;
    return bench.press(force_n, 200).z();
  };
  EXPECT_EQ(press_at(0.09, 4.0), 4.0);
  EXPECT_NEAR(press_at(0.095, 4.0), 2.0, 1e-9);
  EXPECT_EQ(press_at(0.1, 4.0), 0.0);
  EXPECT_EQ(press_at(0.15, 4.0), 0.0);
  EXPECT_EQ(press_at(0.15, -4.0), -4.0);
  EXPECT_EQ(press_at(0.15, 0.0), 0.0);
  EXPECT_NEAR(press_at(-0.095, -4.0), -2.0, 1e-9);
  EXPECT_EQ(press_at(-0.1, -4.0), 0.0);
  EXPECT_GT(bench.governor.counters().workspace_limited, 200U);
}

TEST(SafetyGovernor, OnAShortAxisTheForceFadesOverATenthOfIt) {
  DeviceLimits limits = device_limits();
  limits.workspace_min_m.z() = -0.02;
  limits.workspace_max_m.z() = 0.02;
  for (const auto& [z_m, share] : {std::pair{0.0155, 1.0}, {0.018, 0.5}, {0.02, 0.0}}) {
    Bench bench(limits);
    bench.sample.p_WD.z() = z_m;
    EXPECT_NEAR(bench.press(4.0, 300).z(), 4.0 * share, 1e-9) << z_m;
  }
}

TEST(SafetyGovernor, HotMotorsGetTheContinuousForceWithoutAJump) {
  DeviceLimits limits = device_limits();
  limits.continuous_force_n = 2.0;
  limits.peak_s = 3.0;
  Bench bench(limits);
  double before = 0.0;
  double force_at_peak_n = 0.0;
  for (int n = 0; n < 120'000; ++n) {
    bench.press(8.0, 1);
    const double z = bench.out.force_n.z();
    if (n > 200) {
      ASSERT_LT(std::abs(z - before), 0.05);
    }
    before = z;
    ASSERT_LE(bench.governor.thermal_load(), 1.0 + 1e-6);
    if (n == 2'200) force_at_peak_n = z;
  }
  EXPECT_EQ(force_at_peak_n, 8.0);
  EXPECT_NEAR(bench.out.force_n.z(), 2.0, 0.05);
  EXPECT_GT(bench.governor.counters().thermal_limited, 100'000U);
  EXPECT_EQ(bench.governor.fault(), SafetyFault::none);
  const std::uint64_t limited_before = bench.governor.counters().thermal_limited;
  bench.press(0.1, 5);
  EXPECT_EQ(bench.governor.counters().thermal_limited, limited_before) << "what the motors bear is not reduced";
  bench.press(0.0, 60'000);
  EXPECT_LT(bench.governor.thermal_load(), 0.5);
  EXPECT_EQ(bench.press(8.0, 100).z(), 8.0);
}

TEST(SafetyGovernor, MotorsThatSayTheyAreTooHotLatchUntilTheyAreCool) {
  Bench bench;
  bench.governor.observe_temperature(0.99);
  EXPECT_EQ(bench.press(4.0, 200).z(), 4.0);
  bench.governor.observe_temperature(1.0);
  EXPECT_EQ(bench.governor.fault(), SafetyFault::thermal);
  EXPECT_EQ(bench.press(4.0, 10), Vec3::Zero());
  bench.governor.observe_temperature(0.95);
  EXPECT_FALSE(bench.governor.reset_faults());
  bench.governor.observe_temperature(0.85);
  EXPECT_TRUE(bench.governor.reset_faults());
  EXPECT_EQ(bench.press(4.0, 200).z(), 4.0);
}

// How hot the motors are after a restart is not known.
TEST(SafetyGovernor, AThermalFaultFromBeforeIsResetOnlyWhenTheMotorsMustHaveCooled) {
  DeviceLimits limits = device_limits();
  limits.continuous_force_n = 2.0;
  limits.peak_s = 0.7;
  Bench bench(limits);
  bench.governor.restore_latched_fault(SafetyFault::thermal);
  bench.wait(10);
  EXPECT_FALSE(bench.governor.reset_faults());
  bench.wait(9000);
  EXPECT_TRUE(bench.governor.reset_faults());
}

// The first force is zero because of the ramp, whatever limited the last force before the release.
TEST(SafetyGovernor, TheFirstForceAfterAReleaseIsNotCountedAsLimited) {
  Bench bench;
  bench.sample.p_WD.z() = 0.1;
  bench.press(1.0, 300);
  bench.wait(50);
  bench.sample.p_WD.z() = 0.0;
  bench.now_ns += 200 * kMs;  // so long without a sample that this is not a jump
  const std::uint64_t limited_before = bench.governor.counters().workspace_limited;
  EXPECT_GT(limited_before, 200U);
  EXPECT_GT(bench.press(1.0, 5).z(), 0.0);
  EXPECT_EQ(bench.governor.counters().workspace_limited, limited_before);
}

// The load is a share of the force that the motors bear; it has to be a number even if no force is allowed.
TEST(SafetyGovernor, MotorsThatMayNotPushAreColdOrCoolDown) {
  DeviceLimits limits = device_limits();
  limits.continuous_force_n = 2.0;
  limits.peak_s = 0.7;
  Bench bench(limits);
  bench.governor.forbid_force();
  bench.press(8.0, 10);
  EXPECT_EQ(bench.governor.stats().thermal_load, 0.0);
  bench.governor.restore_latched_fault(SafetyFault::thermal);
  EXPECT_NEAR(bench.governor.stats().thermal_load, 1.0, 1e-9);
  bench.wait(9000);
  EXPECT_LT(bench.governor.stats().thermal_load, 0.9);
}

TEST(SafetyGovernor, HeatDuringAGapWithoutSamplesLatches) {
  DeviceLimits limits = device_limits();
  limits.continuous_force_n = 2.0;
  limits.peak_s = 0.7;
  Bench bench(limits);
  bench.press(8.0, 200);
  bench.now_ns += 4000 * kMs;
  bench.press(8.0, 1);
  EXPECT_EQ(bench.governor.fault(), SafetyFault::thermal);
  EXPECT_FALSE(bench.governor.reset_faults());
  bench.press(0.0, 9000);
  EXPECT_TRUE(bench.governor.reset_faults());
}

TEST(SafetyGovernor, AMachineThatSleptForAnHourHasNotHeatedTheMotors) {
  DeviceLimits limits = device_limits();
  limits.continuous_force_n = 2.0;
  limits.peak_s = 3.0;
  Bench bench(limits);
  bench.press(4.0, 200);
  bench.now_ns += 3'600'000 * kMs;
  EXPECT_EQ(bench.press(4.0, 1), Vec3::Zero());
  EXPECT_EQ(bench.governor.fault(), SafetyFault::none);
  EXPECT_EQ(bench.press(4.0, 200).z(), 4.0);
}

// A source of energy that turns the stylus must end where a source that pushes the stylus has to end.
TEST(SafetyGovernor, ASpentEnergyBudgetLowersTheTorqueAsItDoesTheForce) {
  Bench bench;
  bench.sample.p_WD.x() = -0.08;
  bench.press(0.0, 200);
  for (int n = 0; n < 200; ++n) {
    bench.sample.p_WD.x() += 2e-4;
    bench.cycle(Wrench{Vec3(8, 0, 0), Vec3::Zero()});
  }
  // After a while without samples, the velocity is not known and counts as zero.
  bench.now_ns += 300 * kMs;
  for (int n = 0; n < 200; ++n) bench.cycle(Wrench{Vec3::Zero(), Vec3(0.5, 0, 0)});
  const double spent_j = bench.governor.energy_spent_j();
  const double share = (EnergyBudget::most_j(8.0) - spent_j) / (EnergyBudget::most_j(8.0) - EnergyBudget::free_j(8.0));
  ASSERT_GT(share, 0.2);
  ASSERT_LT(share, 0.95);
  EXPECT_NEAR(bench.out.torque_nm.x(), 0.5 * share, 1e-6);
}

}  // namespace
}  // namespace hapton
