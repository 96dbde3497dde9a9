#include "safety/safety_governor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

DeviceLimits device_limits() {
  return {.max_force_n = 8.0,
          .max_slew_n_per_s = 2000.0,
          .max_stiffness_n_per_m = 1000.0,
          .workspace_min_m = Vec3::Constant(-0.1),
          .workspace_max_m = Vec3::Constant(0.1),
          .max_torque_nm = 0.5,
          .max_torque_slew_nm_per_s = 100.0,
          .max_speed_m_per_s = 2.0};
}

// A device that answers, and someone who asks for forces: a cycle of 1 ms each.
struct Bench {
  explicit Bench(const DeviceLimits& limits = device_limits()) : governor(limits) {}

  const Wrench& cycle(const std::optional<Wrench>& wanted) {
    now_ns += kMs;
    sample.time_ns = now_ns;
    governor.observe(sample, status);
    if (!wanted) return out = governor.step(std::nullopt, now_ns);
    return out = governor.step(WantedWrench{*wanted, now_ns - 100'000}, now_ns);
  }
  Vec3 press(double z_n, int cycles) {
    for (int n = 0; n < cycles; ++n) cycle(Wrench{Vec3(0, 0, z_n), Vec3::Zero()});
    return out.force_n;
  }
  Vec3 wait(int cycles) {
    for (int n = 0; n < cycles; ++n) cycle(std::nullopt);
    return out.force_n;
  }

  SafetyGovernor governor;
  DeviceSample sample;
  DeviceStatus status = DeviceStatus::ready;
  std::int64_t now_ns = 0;
  Wrench out;
};

TEST(SafetyGovernor, ramps_in_then_passes_a_good_force_unchanged) {
  Bench bench;
  EXPECT_LT(bench.press(2.0, 1).z(), 0.05);
  EXPECT_EQ(bench.governor.state(), GovernorState::ramping);
  EXPECT_NEAR(bench.press(2.0, 50).z(), 1.0, 0.05);
  EXPECT_EQ(bench.press(2.0, 100), Vec3(0, 0, 2.0));
  EXPECT_EQ(bench.governor.state(), GovernorState::live);
  const GovernorCounters& counters = bench.governor.counters();
  EXPECT_EQ(counters.clamped + counters.slewed + counters.silences + counters.damped + counters.stopped + counters.braked, 0U);
}

TEST(SafetyGovernor, clamps_the_norm_of_force_and_torque_and_keeps_their_directions) {
  Bench bench;
  for (int n = 0; n < 250; ++n) bench.cycle(Wrench{Vec3(30, 0, 40), Vec3(0, -3, 4)});
  EXPECT_NEAR(bench.out.force_n.norm(), 8.0, 1e-9);
  EXPECT_LT((bench.out.force_n.normalized() - Vec3(0.6, 0, 0.8)).norm(), 1e-9);
  EXPECT_NEAR(bench.out.torque_nm.norm(), 0.5, 1e-9);
  EXPECT_LT((bench.out.torque_nm.normalized() - Vec3(0, -0.6, 0.8)).norm(), 1e-9);
  EXPECT_GT(bench.governor.counters().clamped, 200U);
}

TEST(SafetyGovernor, a_device_without_torque_gets_none) {
  DeviceLimits limits = device_limits();
  limits.max_torque_nm = 0.0;
  Bench bench(limits);
  for (int n = 0; n < 250; ++n) bench.cycle(Wrench{Vec3(0, 0, 1), Vec3(0, -3, 4)});
  EXPECT_EQ(bench.out.torque_nm, Vec3::Zero());
  EXPECT_EQ(bench.out.force_n, Vec3(0, 0, 1));
}

TEST(SafetyGovernor, changes_no_faster_than_the_slew) {
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
  EXPECT_GT(bench.governor.counters().slewed, 90U);
}

TEST(SafetyGovernor, is_zero_after_twenty_milliseconds_of_silence_and_ramps_back) {
  for (const std::int64_t dt : {kMs / 10, kMs, 4 * kMs}) {
    Bench bench;
    for (int n = 0; n < 300; ++n) bench.cycle(Wrench{Vec3(0, 0, 8), Vec3(0.5, 0, 0)});
    ASSERT_EQ(bench.out.force_n, Vec3(0, 0, 8));
    const std::int64_t last = bench.now_ns;
    Wrench before = bench.out;
    while (bench.now_ns < last + 30 * kMs) {
      bench.now_ns += dt - kMs;
      bench.wait(1);
      if (bench.now_ns - last <= 15 * kMs) {
        ASSERT_EQ(bench.out.force_n.z(), 8.0);
      }
      if (bench.now_ns - last >= 20 * kMs) {
        ASSERT_EQ(bench.out.force_n, Vec3::Zero()) << dt;
        ASSERT_EQ(bench.out.torque_nm, Vec3::Zero()) << dt;
      }
      ASSERT_LE((bench.out.force_n - before.force_n).norm(), 2000e-9 * static_cast<double>(dt) * 1.000001);
      before = bench.out;
    }
    EXPECT_TRUE(bench.governor.is_silent());
    EXPECT_EQ(bench.governor.state(), GovernorState::silent);
    EXPECT_EQ(bench.governor.counters().silences, 1U);
    EXPECT_LT(bench.press(8.0, 10).z(), 0.9);
    EXPECT_EQ(bench.press(8.0, 150).z(), 8.0);
  }
}

// A force that was long on its way has used up its time: what counts is how old its sample is, not when it came.
TEST(SafetyGovernor, is_zero_twenty_milliseconds_after_the_sample_however_late_its_force_came) {
  for (const std::int64_t age_ns : {kMs, 8 * kMs, 15 * kMs, 18 * kMs}) {
    Bench bench;
    // Every force as old as that from the beginning on.
    for (int n = 0; n < 300; ++n) {
      bench.now_ns += kMs;
      bench.sample.time_ns = bench.now_ns;
      bench.governor.observe(bench.sample, bench.status);
      bench.out = bench.governor.step(WantedWrench{{Vec3(0, 0, 1), Vec3::Zero()}, bench.now_ns - age_ns}, bench.now_ns);
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

TEST(SafetyGovernor, one_bad_number_lets_go_and_ramps_back) {
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

TEST(SafetyGovernor, bad_numbers_again_and_again_latch) {
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

TEST(SafetyGovernor, what_was_latched_before_its_time_stays_latched_until_the_reset) {
  Bench bench;
  bench.governor.latch_again(SafetyFault::jump);
  EXPECT_EQ(bench.press(2.0, 300), Vec3(0, 0, 0));
  EXPECT_EQ(bench.governor.state(), GovernorState::latched);
  EXPECT_EQ(bench.governor.fault(), SafetyFault::jump);
  EXPECT_EQ(bench.governor.counters().latched, 0U);
  EXPECT_TRUE(bench.governor.reset_faults());
  EXPECT_LT(bench.press(2.0, 1).z(), 0.05);
  EXPECT_EQ(bench.press(2.0, 150), Vec3(0, 0, 2.0));
}

TEST(SafetyGovernor, bad_numbers_now_and_then_do_not_latch) {
  Bench bench;
  for (int n = 0; n < 50; ++n) {
    bench.press(4.0, 150);
    bench.cycle(Wrench{Vec3(kNan, 0, 4), Vec3::Zero()});
  }
  EXPECT_EQ(bench.governor.fault(), SafetyFault::none);
}

TEST(SafetyGovernor, old_repeated_and_future_forces_are_refused_and_do_not_count_as_life) {
  Bench bench;
  bench.press(2.0, 200);
  const std::int64_t answered = bench.now_ns - 100'000;
  const Wrench other{Vec3(0, 0, 7), Vec3::Zero()};
  for (int n = 0; n < 25; ++n) {
    bench.wait(1);
    for (const std::int64_t time_ns :
         {answered, answered - 1, bench.now_ns + 1, std::numeric_limits<std::int64_t>::max(), std::numeric_limits<std::int64_t>::min()}) {
      bench.governor.step(WantedWrench{other, time_ns}, bench.now_ns);
    }
  }
  EXPECT_EQ(bench.wait(1), Vec3::Zero());
  EXPECT_EQ(bench.governor.counters().refused_old, 75U);
  EXPECT_EQ(bench.governor.counters().refused_future, 50U);
  EXPECT_EQ(bench.governor.counters().silences, 1U);
  bench.governor.step(WantedWrench{other, bench.now_ns - 21 * kMs}, bench.now_ns);
  EXPECT_TRUE(bench.governor.is_silent());
}

TEST(SafetyGovernor, is_blind_without_samples_of_the_device) {
  Bench bench;
  bench.press(4.0, 300);
  const std::int64_t seen_ns = bench.now_ns;
  for (int n = 0; n < 40; ++n) {
    bench.now_ns += kMs;
    bench.out = bench.governor.step(WantedWrench{{Vec3(0, 0, 4), Vec3::Zero()}, bench.now_ns}, bench.now_ns);
    ASSERT_EQ(bench.governor.state() == GovernorState::blind, bench.now_ns - seen_ns >= 20 * kMs);
  }
  EXPECT_EQ(bench.out.force_n, Vec3::Zero());
  EXPECT_LT(bench.press(4.0, 20).z(), 1.0);
  EXPECT_EQ(bench.press(4.0, 100).z(), 4.0);

  SafetyGovernor never_looked(device_limits());
  for (std::int64_t now = 0; now < 300 * kMs; now += kMs) {
    ASSERT_EQ(never_looked.step(WantedWrench{{Vec3(0, 0, 4), Vec3::Zero()}, now}, now).force_n, Vec3::Zero());
  }
}

TEST(SafetyGovernor, positions_that_are_none_are_left_out_and_latch_when_they_do_not_end) {
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

TEST(SafetyGovernor, a_jump_of_the_position_latches) {
  Bench bench;
  bench.press(4.0, 300);
  bench.sample.p_WD.x() += 0.004;  // 2 mm at most by speed, 5 mm of tolerance
  bench.press(4.0, 1);
  EXPECT_EQ(bench.governor.fault(), SafetyFault::none);
  bench.sample.p_WD.x() += 0.0071;
  bench.press(4.0, 1);
  EXPECT_EQ(bench.governor.fault(), SafetyFault::jump);
  EXPECT_EQ(bench.press(4.0, 10), Vec3::Zero());
}

TEST(SafetyGovernor, a_hand_may_be_elsewhere_after_a_gap) {
  Bench bench;
  bench.press(4.0, 300);
  bench.now_ns += 200 * kMs;
  bench.sample.p_WD.x() += 0.05;
  EXPECT_EQ(bench.press(4.0, 1), Vec3::Zero());
  EXPECT_EQ(bench.governor.fault(), SafetyFault::none);
  EXPECT_EQ(bench.press(4.0, 150), Vec3(0, 0, 4));
}

// z from -0.09 on, at this speed, pushed along it by 1 N.
void sweep(Bench& bench, double speed_m_per_s, int cycles) {
  for (int n = 0; n < cycles; ++n) {
    bench.sample.p_WD.z() += 1e-3 * speed_m_per_s;
    bench.press(1.0, 1);
  }
}

TEST(SafetyGovernor, what_pushes_a_fast_device_on_fades_to_damping) {
  double before = 1.0;
  for (const double speed : {1.0, 1.3, 1.5, 1.7, 1.9}) {
    Bench bench;
    bench.sample.p_WD.z() = -0.09;
    bench.press(1.0, 200);
    sweep(bench, speed, 50);
    EXPECT_EQ(bench.governor.fault(), SafetyFault::none);
    EXPECT_EQ(bench.governor.counters().braked > 0, speed > 1.2);
    if (speed > 1.2) {
      EXPECT_LT(bench.out.force_n.z(), before - 0.1) << speed;
    } else {
      EXPECT_EQ(bench.out.force_n.z(), 1.0);
    }
    before = bench.out.force_n.z();
  }
  EXPECT_LT(before, -2.0);
}

TEST(SafetyGovernor, a_device_faster_than_its_limit_latches) {
  Bench bench;
  bench.sample.p_WD.z() = -0.09;
  bench.press(1.0, 200);
  sweep(bench, 2.5, 30);
  EXPECT_EQ(bench.governor.fault(), SafetyFault::speed);
  EXPECT_EQ(bench.press(1.0, 10), Vec3::Zero());
}

TEST(SafetyGovernor, energy_given_beyond_what_is_free_is_damped_against_the_motion) {
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
  EXPECT_EQ(bench.out.force_n, Vec3(0, 0, 4));  // nothing is done about what is free
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

TEST(SafetyGovernor, the_end_of_the_workspace_takes_what_pushes_outwards_and_adds_nothing) {
  Bench bench;
  const auto at = [&](double z, double force_n) {
    bench.now_ns += 200 * kMs;
    bench.sample.p_WD.z() = z;
    return bench.press(force_n, 200).z();
  };
  EXPECT_EQ(at(0.09, 4.0), 4.0);
  EXPECT_NEAR(at(0.095, 4.0), 2.0, 1e-9);
  EXPECT_EQ(at(0.1, 4.0), 0.0);
  EXPECT_EQ(at(0.15, 4.0), 0.0);
  EXPECT_EQ(at(0.15, -4.0), -4.0);
  EXPECT_EQ(at(0.15, 0.0), 0.0);
  EXPECT_NEAR(at(-0.095, -4.0), -2.0, 1e-9);
  EXPECT_EQ(at(-0.1, -4.0), 0.0);
  EXPECT_GT(bench.governor.counters().stopped, 200U);
}

TEST(SafetyGovernor, hot_motors_get_the_continuous_force_without_a_jump) {
  DeviceLimits limits = device_limits();
  limits.continuous_force_n = 2.0;
  limits.peak_s = 3.0;
  Bench bench(limits);
  double before = 0.0;
  double at_peak_s = 0.0;
  for (int n = 0; n < 120'000; ++n) {
    bench.press(8.0, 1);
    const double z = bench.out.force_n.z();
    if (n > 200) {
      ASSERT_LT(std::abs(z - before), 0.05);
    }
    before = z;
    ASSERT_LE(bench.governor.thermal_load(), 1.0 + 1e-6);
    if (n == 2'200) at_peak_s = z;
  }
  EXPECT_EQ(at_peak_s, 8.0);
  EXPECT_NEAR(bench.out.force_n.z(), 2.0, 0.05);
  EXPECT_GT(bench.governor.counters().cooled, 100'000U);
  EXPECT_EQ(bench.governor.fault(), SafetyFault::none);
  bench.press(0.0, 60'000);
  EXPECT_LT(bench.governor.thermal_load(), 0.5);
  EXPECT_EQ(bench.press(8.0, 100).z(), 8.0);
}

TEST(SafetyGovernor, motors_that_say_they_are_too_hot_latch_until_they_are_cool) {
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

TEST(SafetyGovernor, heat_that_nobody_watched_latches) {
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

TEST(SafetyGovernor, a_machine_that_slept_for_an_hour_has_not_heated_the_motors) {
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

TEST(SafetyGovernor, a_stylus_that_is_let_go_gets_no_force_and_ramps_back) {
  Bench bench;
  bench.press(4.0, 300);
  bench.sample.is_held = false;
  EXPECT_EQ(bench.press(4.0, 10), Vec3::Zero());
  EXPECT_EQ(bench.governor.state(), GovernorState::not_held);
  EXPECT_EQ(bench.governor.counters().releases, 1U);
  bench.sample.is_held = true;
  EXPECT_LT(bench.press(4.0, 20).z(), 1.0);
  EXPECT_EQ(bench.press(4.0, 100).z(), 4.0);
}

TEST(SafetyGovernor, a_button_can_be_asked_for) {
  Bench bench;
  bench.governor.require_button(1);
  bench.sample.buttons = 0b101;
  EXPECT_EQ(bench.press(4.0, 300), Vec3::Zero());
  bench.sample.buttons = 0b010;
  EXPECT_EQ(bench.press(4.0, 300).z(), 4.0);
  // It can be asked for, never waived.
  for (const int nonsense : {-1, 32, 1000}) bench.governor.require_button(nonsense);
  bench.governor.require_button(2);
  EXPECT_EQ(bench.press(4.0, 300), Vec3::Zero());
  bench.sample.buttons = 0b110;
  EXPECT_EQ(bench.press(4.0, 300).z(), 4.0);
}

TEST(SafetyGovernor, a_switch_is_held_only_where_the_device_tells_so_now) {
  Bench bench;
  bench.sample.buttons = 0b010;
  bench.press(4.0, 300);
  EXPECT_FALSE(bench.governor.is_switch_held()) << "none was asked for";
  bench.governor.require_button(1);
  bench.wait(1);
  EXPECT_TRUE(bench.governor.is_switch_held());
  // A device that is away repeats its last sample, button and all.
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

TEST(SafetyGovernor, a_device_away_or_calibrating_gets_no_force_and_ramps_on_return) {
  for (const DeviceStatus status : {DeviceStatus::away, DeviceStatus::calibrating}) {
    Bench bench;
    bench.press(4.0, 300);
    bench.status = status;
    EXPECT_EQ(bench.press(4.0, 10), Vec3::Zero());
    EXPECT_EQ(bench.governor.state(), status == DeviceStatus::away ? GovernorState::away : GovernorState::calibrating);
    bench.press(4.0, 500);
    bench.status = DeviceStatus::ready;
    bench.sample.p_WD = Vec3(0.08, -0.08, 0.01);  // no jump: it was away
    EXPECT_LT(bench.press(4.0, 20).z(), 1.0);
    EXPECT_EQ(bench.press(4.0, 100).z(), 4.0);
    EXPECT_EQ(bench.governor.fault(), SafetyFault::none);
  }
}

TEST(SafetyGovernor, a_device_that_failed_latches) {
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

TEST(SafetyGovernor, a_latched_fault_outlives_everything_but_a_reset_and_then_ramps) {
  Bench bench;
  bench.press(4.0, 300);
  bench.sample.p_WD.x() = 0.05;
  bench.press(4.0, 1);
  ASSERT_EQ(bench.governor.fault(), SafetyFault::jump);
  EXPECT_EQ(bench.press(4.0, 10), Vec3::Zero());
  // Silence, other forces, going away, being let go, time: none of it is a reset.
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

TEST(SafetyGovernor, no_reset_while_the_device_still_moves_too_fast) {
  Bench bench;
  bench.sample.p_WD.x() = -0.09;
  bench.press(1.0, 100);
  for (int n = 0; n < 30; ++n) {
    bench.sample.p_WD.x() += 0.0025;
    bench.press(1.0, 1);
  }
  ASSERT_EQ(bench.governor.fault(), SafetyFault::speed);
  EXPECT_FALSE(bench.governor.reset_faults());
  EXPECT_EQ(bench.governor.counters().resets_refused, 1U);
  bench.press(1.0, 50);
  EXPECT_TRUE(bench.governor.reset_faults());
}

TEST(SafetyGovernor, the_first_fault_is_the_one_that_is_told) {
  Bench bench;
  bench.press(4.0, 300);
  bench.sample.p_WD.x() = 0.05;
  bench.press(4.0, 1);
  bench.status = DeviceStatus::fault;
  bench.press(4.0, 1);
  EXPECT_EQ(bench.governor.fault(), SafetyFault::jump);
  EXPECT_EQ(bench.governor.counters().latched, 1U);
}

TEST(SafetyGovernor, tightening_at_full_force_takes_effect_within_the_slew) {
  Bench bench;
  bench.press(8.0, 300);
  bench.governor.tighten({.max_force_n = 2.0, .max_slew_n_per_s = 1e9});
  EXPECT_NEAR(bench.press(8.0, 1).z(), 6.0, 1e-6);
  EXPECT_NEAR(bench.press(8.0, 10).z(), 2.0, 1e-9);
}

TEST(SafetyGovernor, a_tight_slew_never_delays_letting_go) {
  Bench bench;
  bench.governor.tighten({.max_slew_n_per_s = 50.0});
  ASSERT_NEAR(bench.press(8.0, 1000).z(), 8.0, 1e-9);
  EXPECT_EQ(bench.wait(20), Vec3::Zero());
}

TEST(SafetyGovernor, unusable_limits_give_no_force) {
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

TEST(SafetyGovernor, takes_nothing_from_the_heap) {
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

}  // namespace
}  // namespace hapton
