// What the evaluator says about outputs that no governor may give: a check that cannot fail tests nothing.
#include "tools/governor/governor_evaluator.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>

#include "tests/support/time_units.h"

namespace hapton {
namespace {

DeviceLimits evaluated_device() {
  return {.max_force_n = 4.0,
          .max_slew_n_per_s = 1000.0,
          .workspace_min_m = Vec3::Constant(-0.1),
          .workspace_max_m = Vec3::Constant(0.1),
          .max_torque_nm = 0.1,
          .max_torque_slew_nm_per_s = 25.0,
          .continuous_force_n = 2.0,
          .peak_s = 1.0,
          .max_speed_m_per_s = 2.0};
}

// These two properties are all that the evaluator uses of a program.
HostileProgram find_program(bool has_button) {
  for (std::uint64_t seed = 1;; ++seed) {
    const HostileProgram program(seed);
    if (!program.is_physical() && (program.button() >= 1 && program.button() <= 32) == has_button) return program;
  }
}

Wrench push_z(double force_n) { return {.force_n = Vec3(0.0, 0.0, force_n), .torque_nm = Vec3::Zero()}; }

// A governor in calm cycles of 1 ms, and an evaluator that can be given other outputs than the governor's.
struct EvaluatedGovernor {
  explicit EvaluatedGovernor(bool has_button = false) : program(find_program(has_button)) {
    governor.require_button(program.button());
    step.now_ns = kSecond;
    step.sample.buttons = ~0U;
  }

  // Runs one cycle of the governor and returns its output.
  Wrench cycle(std::int64_t passed_ns = kMs) {
    step.now_ns += passed_ns;
    step.sample.time_ns = step.now_ns;
    step.command.reset();
    if (commanded) step.command = WrenchCommand{*commanded, step.now_ns};
    governor.observe(step.sample, step.status);
    return governor.step(step.command, step.now_ns);
  }
  void evaluate(const Wrench& out, bool was_reset = false) { evaluator.evaluate(step, was_reset, out); }
  void run(int cycles) {
    for (int n = 0; n < cycles; ++n) evaluate(cycle());
  }
  // Runs cycles with this command. The evaluator must allow every output of the governor.
  void run_with(const Wrench& wrench, int cycles) {
    commanded = wrench;
    run(cycles);
    EXPECT_EQ(total(), 0U);
  }
  std::uint64_t count(GovernorBreach breach) const { return evaluator.breaches()[static_cast<std::size_t>(breach)]; }
  std::uint64_t total() const { return std::accumulate(evaluator.breaches().begin(), evaluator.breaches().end(), std::uint64_t{0}); }

  HostileProgram program;
  SafetyGovernor governor{evaluated_device()};
  GovernorEvaluator evaluator{program, governor};
  HostileStep step;
  std::optional<Wrench> commanded;
};

TEST(GovernorEvaluatorTest, WhatIsNoNumberIsABreach) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Wrench& bad : {Wrench{Vec3(nan, 0, 0), Vec3::Zero()}, Wrench{Vec3::Zero(), Vec3(0, nan, 0)}}) {
    EvaluatedGovernor governed;
    governed.run_with(push_z(1.0), 200);
    governed.cycle();
    governed.evaluate(bad);
    EXPECT_EQ(governed.count(GovernorBreach::not_finite), 1U);
  }
}

TEST(GovernorEvaluatorTest, MoreThanTheDeviceOrALoweredLimitAllowsIsABreach) {
  EvaluatedGovernor governed;
  governed.run_with({Vec3(0, 0, 4.0), Vec3(0.1, 0, 0)}, 200);
  governed.cycle();
  governed.evaluate({Vec3(0, 0, 4.04), Vec3(0.1, 0, 0)});
  EXPECT_EQ(governed.count(GovernorBreach::force), 1U);
  governed.cycle();
  governed.evaluate({Vec3(0, 0, 4.0), Vec3(0.104, 0, 0)});
  EXPECT_EQ(governed.count(GovernorBreach::force), 1U);
  EXPECT_EQ(governed.count(GovernorBreach::torque), 1U);
  EXPECT_EQ(governed.count(GovernorBreach::force_slew) + governed.count(GovernorBreach::torque_slew), 0U);

  EvaluatedGovernor lowered;
  lowered.run_with({Vec3(0, 0, 4.0), Vec3(0.1, 0, 0)}, 200);
  lowered.governor.tighten({.max_force_n = 2.0, .max_torque_nm = 0.05});
  lowered.run_with({Vec3(0, 0, 4.0), Vec3(0.1, 0, 0)}, 1);
  lowered.cycle();
  lowered.evaluate({Vec3(0, 0, 2.5), Vec3(0.06, 0, 0)});
  EXPECT_EQ(lowered.count(GovernorBreach::force), 1U);
  EXPECT_EQ(lowered.count(GovernorBreach::torque), 1U);
}

TEST(GovernorEvaluatorTest, AChangeFasterThanTheSlewIsABreach) {
  EvaluatedGovernor governed;
  governed.run_with({Vec3(0, 0, 1.0), Vec3(0.05, 0, 0)}, 200);
  governed.cycle();
  governed.evaluate({Vec3(0, 0, 1.9), Vec3(0.07, 0, 0)});
  EXPECT_EQ(governed.total(), 0U);
  governed.cycle();
  governed.evaluate({Vec3(0, 0, 3.4), Vec3(0.07, 0, 0)});
  EXPECT_EQ(governed.count(GovernorBreach::force_slew), 1U);
  governed.cycle();
  governed.evaluate({Vec3(0, 0, 3.4), Vec3(0.04, 0, 0)});
  EXPECT_EQ(governed.count(GovernorBreach::torque_slew), 1U);
  EXPECT_EQ(governed.total(), 2U);
}

TEST(GovernorEvaluatorTest, ATightenedSlewMayOnlyBeExceededTowardsZero) {
  EvaluatedGovernor governed;
  governed.run_with(push_z(1.0), 200);
  governed.governor.tighten({.max_slew_n_per_s = 500.0});
  governed.cycle();
  governed.evaluate(push_z(0.1));
  EXPECT_EQ(governed.total(), 0U);
  governed.cycle();
  governed.evaluate(push_z(0.9));
  EXPECT_EQ(governed.count(GovernorBreach::force_slew), 1U);
  EXPECT_EQ(governed.total(), 1U);
}

TEST(GovernorEvaluatorTest, ForceOrTorqueAfterTheCommandTimeoutIsABreach) {
  for (const Wrench& residual : {push_z(0.001), Wrench{Vec3::Zero(), Vec3(1e-4, 0, 0)}}) {
    EvaluatedGovernor governed;
    governed.run_with({Vec3(0, 0, 0.9), Vec3(0.02, 0, 0)}, 200);
    governed.commanded.reset();
    governed.run(18);
    governed.cycle();
    governed.evaluate(residual);
    EXPECT_EQ(governed.total(), 0U) << "19 ms after its sample";
    governed.cycle();
    governed.evaluate(residual);
    EXPECT_EQ(governed.count(GovernorBreach::command_timeout), 1U);
  }
  EvaluatedGovernor silent;
  silent.run(5);
  silent.cycle();
  silent.evaluate(push_z(0.001));
  EXPECT_EQ(silent.count(GovernorBreach::command_timeout), 1U) << "no command has come at all";
}

TEST(GovernorEvaluatorTest, MoreThanTheRampAllowsIsABreach) {
  EvaluatedGovernor governed;
  governed.run_with(push_z(4.0), 11);
  governed.cycle();
  governed.evaluate(push_z(0.45));
  EXPECT_EQ(governed.count(GovernorBreach::ramp), 1U) << "11 ms after the opening: 0.44 N";
  EXPECT_EQ(governed.total(), 1U);
}

TEST(GovernorEvaluatorTest, TheRampBeginsAgainAfterAReleaseAndAfterATimeout) {
  EvaluatedGovernor governed;
  governed.run_with(push_z(1.0), 200);
  governed.step.sample.is_held = false;
  governed.run(2);
  governed.step.sample.is_held = true;
  governed.run(1);
  governed.cycle();
  governed.evaluate(push_z(0.5));
  EXPECT_EQ(governed.count(GovernorBreach::ramp), 1U);

  // The next command comes in the very cycle of the timeout, so the gate is never seen shut.
  EvaluatedGovernor late;
  late.run_with(push_z(1.0), 200);
  late.commanded.reset();
  late.run(19);
  late.commanded = push_z(1.0);
  late.run(1);
  EXPECT_EQ(late.total(), 0U);
  late.cycle();
  late.evaluate(push_z(0.5));
  EXPECT_EQ(late.count(GovernorBreach::ramp), 1U);
}

TEST(GovernorEvaluatorTest, MoreThanWarmMotorsMayGiveIsABreach) {
  EvaluatedGovernor governed;
  governed.run_with(push_z(4.0), 1000);
  Wrench out = governed.cycle();
  ASSERT_LT(out.force_n.z(), 3.9) << "the thermal budget limits it";
  out.force_n *= 1.001;
  governed.evaluate(out);
  EXPECT_EQ(governed.count(GovernorBreach::heat), 1U);
  EXPECT_EQ(governed.total(), 1U);
}

TEST(GovernorEvaluatorTest, MoreThanTheEnergyBudgetLeavesIsABreach) {
  EvaluatedGovernor governed;
  governed.commanded = push_z(4.0);
  const auto move_along = [&] {
    governed.step.sample.p_WD.z() += 2e-4;
    return governed.cycle();
  };
  governed.step.sample.p_WD.z() = -0.08;
  for (int n = 0; n < 400; ++n) governed.evaluate(move_along());
  ASSERT_EQ(governed.total(), 0U);
  Wrench out = move_along();
  ASSERT_LT(out.force_n.z(), 2.0) << "the energy budget limits it";
  ASSERT_GT(out.force_n.z(), 0.01);
  out.force_n *= 1.01;
  governed.evaluate(out);
  EXPECT_EQ(governed.count(GovernorBreach::energy), 1U);
  EXPECT_EQ(governed.total(), 1U);
}

TEST(GovernorEvaluatorTest, OutwardForceAtTheEndOfTheWorkspaceIsABreach) {
  for (const double sign : {1.0, -1.0}) {
    EvaluatedGovernor outside;
    outside.step.sample.p_WD.z() = sign * 0.1;
    outside.run_with(push_z(-sign * 1.0), 200);
    outside.run_with(push_z(sign * 1.0), 10);
    outside.cycle();
    outside.evaluate(push_z(sign * 0.5));
    EXPECT_GT(outside.count(GovernorBreach::workspace), 0U) << sign;

    // Half of the way through the soft stop.
    EvaluatedGovernor near_end;
    near_end.step.sample.p_WD.z() = sign * 0.095;
    near_end.run_with(push_z(sign * 4.0), 200);
    near_end.cycle();
    near_end.evaluate(push_z(sign * 2.1));
    EXPECT_EQ(near_end.count(GovernorBreach::workspace), 1U) << sign;
    EXPECT_EQ(near_end.total(), 1U);
  }
}

// Beyond the end, the outward force may never grow, and it has to become less.
TEST(GovernorEvaluatorTest, OutwardForceThatIsKeptBeyondTheEndIsABreach) {
  EvaluatedGovernor governed;
  governed.step.sample.p_WD.z() = 0.08;
  governed.run_with(push_z(1.0), 200);
  for (int n = 0; n < 200; ++n) {
    governed.step.sample.p_WD.z() += 2e-4;
    governed.cycle();
    governed.evaluate(push_z(1.0));
    if (governed.step.sample.p_WD.z() < 0.0999) {
      ASSERT_EQ(governed.total(), 0U) << n;
    }
  }
  EXPECT_GT(governed.count(GovernorBreach::workspace), 50U);
  EXPECT_EQ(governed.count(GovernorBreach::workspace), governed.total());
}

// Whatever shuts the gate, the force has to sink as fast as the device allows.
TEST(GovernorEvaluatorTest, ForceThatStaysWhileTheGateIsShutIsABreach) {
  const auto shut = [](auto&& shut_gate, bool has_button = false) {
    EvaluatedGovernor released(has_button);
    released.run_with(push_z(1.0), 200);
    shut_gate(released);
    released.run(3);
    EXPECT_EQ(released.total(), 0U) << "the governor releases it";

    EvaluatedGovernor unreleased(has_button);
    unreleased.run_with(push_z(1.0), 200);
    shut_gate(unreleased);
    unreleased.cycle();
    unreleased.evaluate(push_z(1.0));
    EXPECT_EQ(unreleased.count(GovernorBreach::gate), 1U);
    EXPECT_EQ(unreleased.total(), 1U);
  };
  shut([](EvaluatedGovernor& governed) { governed.step.sample.is_held = false; });
  shut([](EvaluatedGovernor& governed) { governed.step.sample.buttons = 0; }, true);
  shut([](EvaluatedGovernor& governed) { governed.step.status = DeviceStatus::away; });
  shut([](EvaluatedGovernor& governed) { governed.step.status = DeviceStatus::calibrating; });
  shut([](EvaluatedGovernor& governed) { governed.governor.observe_temperature(1.0); });
}

// There are too few invalid samples for a fault, but it is too long since the last valid one.
TEST(GovernorEvaluatorTest, ForceWithoutAPoseFor20MsIsABreach) {
  EvaluatedGovernor governed;
  governed.run_with(push_z(1.0), 200);
  governed.step.sample.p_WD.x() = std::numeric_limits<double>::quiet_NaN();
  for (int n = 0; n < 2; ++n) governed.evaluate(governed.cycle(8 * kMs));
  EXPECT_EQ(governed.total(), 0U);
  governed.cycle(4 * kMs);
  governed.evaluate(push_z(1.0));
  EXPECT_EQ(governed.count(GovernorBreach::gate), 1U);
  EXPECT_EQ(governed.total(), 1U);
}

TEST(GovernorEvaluatorTest, AFaultThatEndsWithoutAResetIsABreach) {
  for (const bool was_reset : {true, false}) {
    EvaluatedGovernor governed;
    governed.run_with(push_z(1.0), 200);
    governed.step.status = DeviceStatus::fault;
    governed.run(5);
    governed.step.status = DeviceStatus::ready;
    governed.run(5);
    ASSERT_TRUE(governed.governor.reset_faults());
    governed.evaluate(governed.cycle(), was_reset);
    EXPECT_EQ(governed.count(GovernorBreach::unlatched), was_reset ? 0U : 1U);
    EXPECT_EQ(governed.total(), governed.count(GovernorBreach::unlatched));
  }
}

// The evaluator sees what the governor did not, so no fault is latched.
TEST(GovernorEvaluatorTest, AFaultThatIsNotLatchedIsABreach) {
  const auto count_for = [](auto&& change) {
    EvaluatedGovernor governed;
    governed.run(50);
    const Wrench out = governed.cycle();
    change(governed.step);
    governed.evaluate(out);
    EXPECT_EQ(governed.count(GovernorBreach::not_latched), governed.total());
    return governed.total();
  };
  EXPECT_EQ(count_for([](HostileStep& step) { step.status = DeviceStatus::fault; }), 1U);
  EXPECT_EQ(count_for([](HostileStep& step) { step.temperature = 1.0; }), 1U);
  EXPECT_EQ(count_for([](HostileStep& step) { step.temperature = 0.99; }), 0U);
  EXPECT_EQ(count_for([](HostileStep& step) { step.sample.p_WD.x() = 0.0071; }), 1U) << "5 mm, and 2 m/s";
  EXPECT_EQ(count_for([](HostileStep& step) { step.sample.p_WD.x() = 0.0069; }), 0U);
  const auto turned = [](double radians) {
    return [radians](HostileStep& step) { step.sample.q_WT = Quat(Eigen::AngleAxisd(radians, Vec3::UnitZ())); };
  };
  EXPECT_EQ(count_for(turned(0.26)), 1U) << "0.2 rad, and 50 rad/s";
  EXPECT_EQ(count_for(turned(0.24)), 0U);
}

TEST(GovernorEvaluatorTest, FiveBadValuesInARowThatLatchNothingAreABreach) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto counts_for = [](auto&& change) {
    EvaluatedGovernor governed;
    governed.run(50);
    for (int n = 1; n <= 5; ++n) {
      governed.step.sample.p_WD = Vec3::Zero();
      const Wrench out = governed.cycle();
      change(governed.step);
      governed.evaluate(out);
      EXPECT_EQ(governed.count(GovernorBreach::not_latched), n < 5 ? 0U : 1U) << n;
    }
    EXPECT_EQ(governed.total(), 1U);
  };
  counts_for([&](HostileStep& step) { step.command = WrenchCommand{{Vec3(nan, 0, 0), Vec3::Zero()}, step.now_ns}; });
  counts_for([&](HostileStep& step) { step.command = WrenchCommand{{Vec3::Zero(), Vec3(0, 0, nan)}, step.now_ns}; });
  counts_for([&](HostileStep& step) { step.sample.p_WD.y() = nan; });
}

// No single step of the device is a jump: only over 20 ms is the device faster than a hand.
TEST(GovernorEvaluatorTest, ADeviceThatIsTooFastAndLatchesNothingIsABreach) {
  for (const double step_m : {0.0040, 0.0045}) {
    EvaluatedGovernor governed;
    governed.run(50);
    for (int n = 1; n <= 60; ++n) {
      governed.step.sample.p_WD = Vec3::Zero();
      const Wrench out = governed.cycle();
      governed.step.sample.p_WD.z() = step_m * n;
      governed.evaluate(out);
    }
    EXPECT_EQ(governed.count(GovernorBreach::not_latched) > 0, step_m > 0.00425) << step_m;
    EXPECT_EQ(governed.count(GovernorBreach::not_latched), governed.total());
  }
}

}  // namespace
}  // namespace hapton
