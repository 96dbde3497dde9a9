#include "safety/safety_governor.h"

#include <gtest/gtest.h>

#include "tests/safety/governor_bench.h"

namespace hapton {
namespace {

TEST(SafetyGovernor, RampsInThenPassesAGoodForceUnchanged) {
  Bench bench;
  EXPECT_LT(bench.press(2.0, 1).z(), 0.05);
  EXPECT_EQ(bench.governor.state(), GovernorState::ramping);
  EXPECT_NEAR(bench.press(2.0, 50).z(), 1.0, 0.05);
  EXPECT_EQ(bench.press(2.0, 100), Vec3(0, 0, 2.0));
  EXPECT_EQ(bench.governor.state(), GovernorState::live);
  const GovernorCounters& counters = bench.governor.counters();
  EXPECT_EQ(counters.clamped + counters.rate_limited + counters.command_timeouts + counters.damped + counters.workspace_limited +
                counters.speed_limited,
            0U);
}

TEST(SafetyGovernor, ClampsTheNormOfForceAndTorqueAndKeepsTheirDirections) {
  Bench bench;
  for (int n = 0; n < 250; ++n) bench.cycle(Wrench{Vec3(30, 0, 40), Vec3(0, -3, 4)});
  EXPECT_NEAR(bench.out.force_n.norm(), 8.0, 1e-9);
  EXPECT_LT((bench.out.force_n.normalized() - Vec3(0.6, 0, 0.8)).norm(), 1e-9);
  EXPECT_NEAR(bench.out.torque_nm.norm(), 0.5, 1e-9);
  EXPECT_LT((bench.out.torque_nm.normalized() - Vec3(0, -0.6, 0.8)).norm(), 1e-9);
  EXPECT_GT(bench.governor.counters().clamped, 200U);
}

TEST(SafetyGovernor, ADeviceWithoutTorqueGetsNone) {
  DeviceLimits limits = device_limits();
  limits.max_torque_nm = 0.0;
  Bench bench(limits);
  for (int n = 0; n < 250; ++n) bench.cycle(Wrench{Vec3(0, 0, 1), Vec3(0, -3, 4)});
  EXPECT_EQ(bench.out.torque_nm, Vec3::Zero());
  EXPECT_EQ(bench.out.force_n, Vec3(0, 0, 1));
}

TEST(SafetyGovernor, AForceAtTheLimitIsNotCountedAsClamped) {
  Bench bench;
  bench.press(8.0, 300);
  EXPECT_EQ(bench.governor.counters().clamped, 0U);
  bench.press(8.001, 1);
  EXPECT_EQ(bench.governor.counters().clamped, 1U);
}

TEST(SafetyGovernor, AForceThatIsForbiddenWhileItIsWrittenIsReleased) {
  Bench bench;
  for (int n = 0; n < 300; ++n) bench.cycle(Wrench{Vec3(0, 0, 4), Vec3(0.3, 0, 0)});
  ASSERT_NEAR(bench.out.force_n.z(), 4.0, 1e-9);
  ASSERT_NEAR(bench.out.torque_nm.x(), 0.3, 1e-9);
  bench.governor.forbid_force();
  for (int n = 0; n < 10; ++n) bench.cycle(Wrench{Vec3(0, 0, 4), Vec3(0.3, 0, 0)});
  EXPECT_EQ(bench.out.force_n, Vec3::Zero());
  EXPECT_EQ(bench.out.torque_nm, Vec3::Zero());
}

TEST(SafetyGovernor, ChangesNoFasterThanTheSlew) {
  Bench bench;
  bench.press(1.0, 200);
  Wrench before = bench.out;
  for (int n = 0; n < 100; ++n) {
    const double sign = n % 2 == 0 ? -1.0 : 1.0;
    bench.cycle(Wrench{Vec3(sign * 8, 0, 0), Vec3(0, sign * 0.5, 0)});
    ASSERT_LE((bench.out.force_n - before.force_n).norm(), 2.0 + 1e-9);
    ASSERT_LE((bench.out.torque_nm - before.torque_nm).norm(), 0.1 + 1e-9);
    before = bench.out;
  }
  EXPECT_GT(bench.governor.counters().rate_limited, 90U);
}

// A latched fault sets the limit to zero at once, but the present force and torque fall no faster than their release rates.
TEST(SafetyGovernor, WhenAFaultLatchesForceAndTorqueGoAtTheReleaseRate) {
  Bench bench;
  for (int n = 0; n < 300; ++n) bench.cycle(Wrench{Vec3(0, 0, 8), Vec3(0.5, 0, 0)});
  ASSERT_EQ(bench.out.torque_nm, Vec3(0.5, 0, 0));
  bench.status = DeviceStatus::fault;
  for (int n = 1; n <= 6; ++n) {
    bench.cycle(Wrench{Vec3(0, 0, 8), Vec3(0.5, 0, 0)});
    EXPECT_NEAR(bench.out.force_n.z(), std::max(8.0 - 2.0 * n, 0.0), 1e-6) << n;
    EXPECT_NEAR(bench.out.torque_nm.x(), std::max(0.5 - 0.1 * n, 0.0), 1e-6) << n;
  }
  EXPECT_EQ(bench.out.torque_nm, Vec3::Zero());
}

TEST(SafetyGovernor, IsZeroTwentyMillisecondsAfterTheLastCommandAndRampsBack) {
  for (const std::int64_t period_ns : {kMs / 10, kMs, 4 * kMs}) {
    Bench bench;
    for (int n = 0; n < 300; ++n) bench.cycle(Wrench{Vec3(0, 0, 8), Vec3(0.5, 0, 0)});
    ASSERT_EQ(bench.out.force_n, Vec3(0, 0, 8));
    const std::int64_t last_command_ns = bench.now_ns;
    Wrench before = bench.out;
    while (bench.now_ns < last_command_ns + 30 * kMs) {
      bench.now_ns += period_ns - kMs;
      bench.wait(1);
      if (bench.now_ns - last_command_ns <= 15 * kMs) {
        ASSERT_EQ(bench.out.force_n.z(), 8.0);
      }
      if (bench.now_ns - last_command_ns >= 20 * kMs) {
        ASSERT_EQ(bench.out.force_n, Vec3::Zero()) << period_ns;
        ASSERT_EQ(bench.out.torque_nm, Vec3::Zero()) << period_ns;
      }
      ASSERT_LE((bench.out.force_n - before.force_n).norm(), 2000e-9 * static_cast<double>(period_ns) * 1.000001);
      before = bench.out;
    }
    EXPECT_TRUE(bench.governor.has_timed_out());
    EXPECT_EQ(bench.governor.state(), GovernorState::no_command);
    EXPECT_EQ(bench.governor.counters().command_timeouts, 1U);
    EXPECT_LT(bench.press(8.0, 10).z(), 0.9);
    EXPECT_EQ(bench.press(8.0, 150).z(), 8.0);
  }
}

TEST(SafetyGovernor, ACommandThatComesExactlyAtTheTimeoutRampsIn) {
  Bench bench;
  bench.press(4.0, 300);
  const std::int64_t replied_ns = bench.now_ns - 100'000;
  bench.wait(19);
  const auto command_at = [&](std::int64_t now_ns) {
    bench.sample.time_ns = bench.now_ns = now_ns;
    bench.governor.observe(bench.sample, bench.status);
    return bench.governor.step(WrenchCommand{{Vec3(0, 0, 4), Vec3::Zero()}, now_ns}, now_ns).force_n.z();
  };
  command_at(replied_ns + kCommandTimeoutNs);
  EXPECT_EQ(bench.governor.counters().command_timeouts, 1U);
  EXPECT_LT(command_at(replied_ns + kCommandTimeoutNs + 3 * kMs), 1.0);
  // A command for a sample as old as the command timeout is rejected.
  const std::uint64_t rejected_before = bench.governor.counters().rejected_old;
  bench.governor.step(WrenchCommand{{Vec3(0, 0, 4), Vec3::Zero()}, bench.now_ns + 1}, bench.now_ns + 1 + kCommandTimeoutNs);
  EXPECT_EQ(bench.governor.counters().rejected_old, rejected_before + 1);
}

// The age of a force counts from its sample, not from its arrival.
TEST(SafetyGovernor, IsZeroTwentyMillisecondsAfterTheSampleHoweverLateItsForceCame) {
  for (const std::int64_t age_ns : {kMs, 8 * kMs, 15 * kMs, 18 * kMs}) {
    Bench bench;
    // From the beginning, each force is for a sample that is age_ns old.
    for (int n = 0; n < 300; ++n) {
      bench.now_ns += kMs;
      bench.sample.time_ns = bench.now_ns;
      bench.governor.observe(bench.sample, bench.status);
      bench.out = bench.governor.step(WrenchCommand{{Vec3(0, 0, 1), Vec3::Zero()}, bench.now_ns - age_ns}, bench.now_ns);
    }
    ASSERT_NE(bench.out.force_n, Vec3::Zero()) << age_ns;
    const std::int64_t sample_ns = bench.now_ns - age_ns;
    while (bench.now_ns - sample_ns < 40 * kMs) {
      bench.wait(1);
      if (bench.now_ns - sample_ns >= 20 * kMs) {
        ASSERT_EQ(bench.out.force_n, Vec3::Zero()) << age_ns << ", " << bench.now_ns - sample_ns;
      }
    }
  }
}

TEST(SafetyGovernor, OneInvalidNumberReleasesTheForceAndRampsBack) {
  for (const double bad : {kNan, kInf, -kInf}) {
    for (const bool is_torque : {false, true}) {
      Bench bench;
      bench.press(4.0, 300);
      Wrench wrench{Vec3(0, 0, 4), Vec3::Zero()};
      (is_torque ? wrench.torque_nm : wrench.force_n).y() = bad;
      EXPECT_LT(bench.cycle(wrench).force_n.z(), 4.0);
      EXPECT_EQ(bench.wait(5), Vec3::Zero());
      EXPECT_EQ(bench.governor.counters().not_finite, 1U);
      EXPECT_EQ(bench.governor.fault(), SafetyFault::none);
      EXPECT_LT(bench.press(4.0, 20).z(), 1.0);
      EXPECT_EQ(bench.press(4.0, 150).z(), 4.0);
    }
  }
}

TEST(SafetyGovernor, BadNumbersAgainAndAgainLatch) {
  for (const bool is_torque : {false, true}) {
    Bench bench;
    bench.press(4.0, 300);
    Wrench wrench{Vec3(0, 0, 4), Vec3::Zero()};
    (is_torque ? wrench.torque_nm : wrench.force_n).y() = kNan;
    for (int n = 0; n < 4; ++n) {
      bench.cycle(wrench);
      bench.press(4.0, 10);
    }
    EXPECT_EQ(bench.governor.fault(), SafetyFault::none);
    bench.cycle(wrench);
    EXPECT_EQ(bench.governor.fault(), is_torque ? SafetyFault::torque : SafetyFault::not_finite);
    EXPECT_EQ(bench.press(4.0, 300), Vec3::Zero());
  }
}

TEST(SafetyGovernor, AResetForgetsTheBadNumbersThatLatched) {
  for (const bool is_torque : {false, true}) {
    Bench bench;
    bench.press(4.0, 300);
    Wrench wrench{Vec3(0, 0, 4), Vec3::Zero()};
    (is_torque ? wrench.torque_nm : wrench.force_n).y() = kNan;
    for (int n = 0; n < 5; ++n) bench.cycle(wrench);
    ASSERT_NE(bench.governor.fault(), SafetyFault::none);
    ASSERT_TRUE(bench.governor.reset_faults());
    for (int n = 0; n < 4; ++n) bench.cycle(wrench);
    EXPECT_EQ(bench.governor.fault(), SafetyFault::none) << is_torque;
  }
}

TEST(SafetyGovernor, AResetForgetsTheInvalidPosesThatLatched) {
  Bench bench;
  bench.press(4.0, 300);
  const auto lose_pose = [&](int cycles) {
    bench.sample.p_WD.x() = kNan;
    bench.press(4.0, cycles);
    bench.sample.p_WD.x() = 0.0;
    bench.press(4.0, 1);
  };
  lose_pose(5);
  ASSERT_EQ(bench.governor.fault(), SafetyFault::position);
  bench.sample.p_WD.x() = kNan;
  bench.press(4.0, 25);
  EXPECT_FALSE(bench.governor.reset_faults()) << "nobody knows where the device is";
  bench.sample.p_WD.x() = 0.0;
  bench.press(4.0, 500);
  ASSERT_TRUE(bench.governor.reset_faults());
  lose_pose(4);
  EXPECT_EQ(bench.governor.fault(), SafetyFault::none) << "five are too many, counted from the reset on";
  lose_pose(1);
  EXPECT_EQ(bench.governor.fault(), SafetyFault::position);
}

TEST(SafetyGovernor, BadNumbersNowAndThenDoNotLatch) {
  Bench bench;
  for (int n = 0; n < 50; ++n) {
    bench.press(4.0, 150);
    bench.cycle(Wrench{Vec3(kNan, 0, 4), Vec3::Zero()});
  }
  EXPECT_EQ(bench.governor.fault(), SafetyFault::none);
}

TEST(SafetyGovernor, OldRepeatedAndFutureForcesAreRejectedAndDoNotRenewTheTimeout) {
  Bench bench;
  bench.press(2.0, 200);
  const std::int64_t replied_ns = bench.now_ns - 100'000;
  const Wrench other{Vec3(0, 0, 7), Vec3::Zero()};
  for (int n = 0; n < 25; ++n) {
    bench.wait(1);
    for (const std::int64_t time_ns : {replied_ns, replied_ns - 1, bench.now_ns + 1, std::numeric_limits<std::int64_t>::max(),
                                       std::numeric_limits<std::int64_t>::min()}) {
      bench.governor.step(WrenchCommand{other, time_ns}, bench.now_ns);
    }
  }
  EXPECT_EQ(bench.wait(1), Vec3::Zero());
  EXPECT_EQ(bench.governor.counters().rejected_old, 75U) << "25 cycles with three old ones each";
  EXPECT_EQ(bench.governor.counters().rejected_future, 50U) << "and with two of the future";
  EXPECT_EQ(bench.governor.counters().command_timeouts, 1U);
  bench.governor.step(WrenchCommand{other, bench.now_ns - 21 * kMs}, bench.now_ns);
  EXPECT_TRUE(bench.governor.has_timed_out());
}

TEST(SafetyGovernor, TighteningAtFullForceTakesEffectWithinTheSlew) {
  Bench bench;
  bench.press(8.0, 300);
  bench.governor.tighten({.max_force_n = 2.0, .max_slew_n_per_s = 1e9});
  EXPECT_NEAR(bench.press(8.0, 1).z(), 6.0, 1e-6);
  EXPECT_NEAR(bench.press(8.0, 10).z(), 2.0, 1e-9);
}

TEST(SafetyGovernor, ATightSlewNeverDelaysTheRelease) {
  Bench bench;
  bench.governor.tighten({.max_slew_n_per_s = 50.0});
  ASSERT_NEAR(bench.press(8.0, 1000).z(), 8.0, 1e-9);
  EXPECT_EQ(bench.wait(20), Vec3::Zero());
}

TEST(SafetyGovernor, UnusableLimitsGiveNoForce) {
  for (const auto& [force, slew] : {std::pair{kNan, 1.0}, {0.0, 1.0}, {1.0, -1.0}, {kInf, 1.0}, {1.0, kNan}}) {
    DeviceLimits limits = device_limits();
    limits.max_force_n = force;
    limits.max_slew_n_per_s = slew;
    Bench bench(limits);
    bench.press(8.0, 300);
    EXPECT_EQ(bench.out.force_n, Vec3::Zero());
    EXPECT_EQ(bench.out.torque_nm, Vec3::Zero());
  }
}

TEST(SafetyGovernor, UsesNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  AllocationGuard guard;
  Bench bench;
  for (int n = 0; n < 5000; ++n) {
    bench.sample.p_WD.x() = n % 700 == 0 ? kNan : 0.03 * std::sin(0.01 * n);
    bench.cycle(n % 900 < 800 ? std::optional(Wrench{Vec3(n % 97 == 0 ? kInf : 3.0, n % 13, 0), Vec3(0, 1, 0)}) : std::nullopt);
    if (n % 1000 == 0) bench.governor.reset_faults();
  }
  EXPECT_EQ(guard.count(), 0U);
}

TEST(SafetyGovernor, ATightenedSlewHoldsForTheTorqueAsForTheForce) {
  Bench bench;
  bench.governor.tighten({.max_slew_n_per_s = 1000.0, .max_torque_slew_nm_per_s = 60.0});
  for (int n = 0; n < 300; ++n) bench.cycle(Wrench{Vec3(4, 0, 0), Vec3(0, 0.4, 0)});
  ASSERT_NEAR(bench.out.torque_nm.y(), 0.4, 1e-9);
  double largest_change_n = 0.0;
  double largest_change_nm = 0.0;
  for (int n = 0; n < 40; ++n) {
    const Wrench before = bench.out;
    const double sign = n % 10 < 5 ? -1.0 : 1.0;
    bench.cycle(Wrench{Vec3(sign * 4, 0, 0), Vec3(0, sign * 0.4, 0)});
    largest_change_n = std::max(largest_change_n, (bench.out.force_n - before.force_n).norm());
    largest_change_nm = std::max(largest_change_nm, (bench.out.torque_nm - before.torque_nm).norm());
  }
  EXPECT_NEAR(largest_change_n, 1.0, 1e-6);
  EXPECT_NEAR(largest_change_nm, 0.06, 1e-6);
}

// The damping that brakes a fast device, or one that was given too much energy.
TEST(SafetyGovernor, DampingFollowsTheStiffnessThatTheDeviceBearsOrElseItsForce) {
  DeviceLimits limits = device_limits();
  EXPECT_DOUBLE_EQ(SafetyGovernor(limits).most_damping_n_s_per_m(), 2.0) << "1000 N/m for 2 ms";
  for (const double unknown : {0.0, -1.0, kNan, kInf}) {
    limits.max_stiffness_n_per_m = unknown;
    EXPECT_DOUBLE_EQ(SafetyGovernor(limits).most_damping_n_s_per_m(), 8.0) << "all of the force at 1 m/s";
  }
}

}  // namespace
}  // namespace hapton
