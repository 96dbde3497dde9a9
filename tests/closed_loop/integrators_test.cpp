#include "closed_loop/integrators.h"

#include <gtest/gtest.h>

#include <cmath>

namespace hapton {
namespace {

double error_of(const IntegratorCase& press, Integrator integrator, std::int64_t step_ns, const std::vector<double>& reference) {
  return worst_difference(run_press(press, integrator, step_ns), reference);
}

// Without friction: halving the step divides the error of Euler by 2 and of Runge-Kutta by 16. Both converge to the exact motion.
TEST(Integrators, ConvergeWithTheirOrderToTheExactMotion) {
  const IntegratorCase press{.device = find_device_preset("premium-1.5")->model.with_modes(1), .hand = *find_hand_preset("stylus")};
  IntegratorCase frictionless = press;
  frictionless.device.friction_n = 0.0;
  const std::vector<double> exact = run_press(frictionless, Integrator::exact, 1);
  const double euler_error = error_of(frictionless, Integrator::semi_implicit_euler, 10'000, exact);
  EXPECT_NEAR(euler_error / error_of(frictionless, Integrator::semi_implicit_euler, 5'000, exact), 2.0, 0.1);
  const double runge_kutta_error = error_of(frictionless, Integrator::runge_kutta, 500'000, exact);
  EXPECT_NEAR(runge_kutta_error / error_of(frictionless, Integrator::runge_kutta, 250'000, exact), 16.0, 3.0);
  EXPECT_LT(error_of(frictionless, Integrator::runge_kutta, 5'000, exact), 1e-10);
}

TEST(Integrators, WithFrictionTheExactMotionIsWhatFineStepsApproach) {
  const IntegratorCase press{.device = find_device_preset("touch")->model, .hand = *find_hand_preset("stylus")};
  const std::vector<double> exact = run_press(press, Integrator::exact, 1);
  const double coarse = error_of(press, Integrator::runge_kutta, 200'000, exact);
  const double fine = error_of(press, Integrator::runge_kutta, 500, exact);
  EXPECT_LT(fine, 0.1 * coarse);
  EXPECT_LT(fine, 1e-9);
}

// The hand moves down at 0.2 m/s from 1 mm above the wall until it is 10 mm below, and is at rest there.
TEST(Integrators, ThePressIsAsTheHeaderDescribes) {
  const IntegratorCase press{.device = find_device_preset("touch")->model,
                             .hand = *find_hand_preset("stylus"),
                             .period_ns = 2'000'000,
                             .wall_n_per_m = 700.0,
                             .seconds = 0.2};
  const AxisMotion motion(press.device, press.hand);
  const SteppedMotion stepped(press.device, press.hand, Integrator::runge_kutta, 100'000);
  AxisMotion::State exact_state = motion.rest_at(0.001);
  AxisMotion::StateVector stepped_state = motion.rest_at(0.001).x;
  std::vector<double> exact;
  std::vector<double> stepped_positions_m;
  for (int k = 0; k < 100; ++k) {
    const double goal_m = 0.001 - 0.2 * (1e-9 * static_cast<double>(k * press.period_ns));
    AxisMotion::Input input{.hand_m = std::max(goal_m, -0.010), .hand_m_per_s = goal_m > -0.010 ? -0.2 : 0.0};
    exact.push_back(exact_state.position_m());
    input.command_n = 700.0 * std::max(0.0, -exact_state.position_m());
    motion.advance(exact_state, input, press.period_ns);
    stepped_positions_m.push_back(stepped_state[0]);
    input.command_n = 700.0 * std::max(0.0, -stepped_state[0]);
    stepped.advance(stepped_state, input, press.period_ns);
  }
  EXPECT_EQ(run_press(press, Integrator::exact, 1), exact);
  EXPECT_EQ(run_press(press, Integrator::runge_kutta, 100'000), stepped_positions_m);
  EXPECT_EQ(exact.front(), 0.001);
  EXPECT_LT(exact.back(), -0.001);
}

// Computes each step by the formula: velocities with the force at the beginning of the step, then positions with the new velocities.
TEST(Integrators, AStepOfEulerIsThatOfItsFormula) {
  DeviceModel device = find_device_preset("premium-1.5")->model.with_modes(1);
  const HandModel hand = *find_hand_preset("stylus");
  const AxisMotion::Input input{.command_n = 0.4, .hand_m = -0.002, .hand_m_per_s = -0.1, .push_n = 0.3};
  for (const double friction_n : {0.0, 0.05}) {
    device.friction_n = friction_n;
    const AxisMotion motion(device, hand);
    const AxisPlant& plant = motion.plant();
    ASSERT_GE(plant.masses(), 2);
    const SteppedMotion stepped(device, hand, Integrator::semi_implicit_euler, 10'000);
    AxisMotion::StateVector state = motion.rest_at(0.001).x;
    state[1] = 0.5;
    AxisMotion::StateVector expected = state;
    for (int n = 0; n < 3; ++n) {
      const double since_s = 1e-5 * n;
      const AxisMotion::StateVector rate =
          plant.a * expected + plant.b * Eigen::Vector4d(-0.002 - 0.1 * since_s, -0.1, 0.4, 0.3 - friction_n);
      for (int mass = 0; mass < plant.masses(); ++mass) {
        expected[2 * mass + 1] += 1e-5 * rate[2 * mass + 1];
        expected[2 * mass] += 1e-5 * expected[2 * mass + 1];
      }
      if (plant.has_amplifier) expected[plant.states() - 1] += 1e-5 * rate[plant.states() - 1];
    }
    stepped.advance(state, input, 30'000);
    EXPECT_LT((state - expected).cwiseAbs().maxCoeff(), 1e-15) << friction_n;
  }
}

// A mass at rest stays where friction exceeds the push, and breaks away where it does not.
TEST(Integrators, FrictionHoldsUpToItsOwnForce) {
  DeviceModel device = find_device_preset("touch")->model;
  device.friction_n = 0.5;
  const AxisMotion motion(device, *find_hand_preset("stylus"));
  for (const Integrator integrator : {Integrator::runge_kutta, Integrator::semi_implicit_euler}) {
    const SteppedMotion stepped(device, *find_hand_preset("stylus"), integrator, 10'000);
    for (const double sign : {-1.0, 1.0}) {
      AxisMotion::StateVector state = motion.rest_at(0.0).x;
      stepped.advance(state, {.push_n = 0.49 * sign}, 10'000);
      EXPECT_EQ(state[0], 0.0);
      EXPECT_EQ(state[1], 0.0);
      stepped.advance(state, {.push_n = 0.51 * sign}, 10'000);
      EXPECT_GT(sign * state[0], 0.0);
      EXPECT_GT(sign * state[1], 0.0);
      // Where friction would reverse the motion within a step, it brings the mass to rest.
      state[1] = sign * 1e-7;
      stepped.advance(state, {}, 10'000);
      EXPECT_EQ(state[1], 0.0);
    }
  }
}

TEST(Integrators, HaveTheNamesOfTheReports) {
  EXPECT_EQ(to_string(Integrator::exact), "exact");
  EXPECT_EQ(to_string(Integrator::runge_kutta), "runge_kutta_4");
  EXPECT_EQ(to_string(Integrator::semi_implicit_euler), "semi_implicit_euler");
}

TEST(Integrators, TheWorstDifferenceIsOverTheShorterRun) {
  const std::vector<double> run = {1.0, -2.0, 5.0};
  EXPECT_EQ(worst_difference(run, std::vector<double>{1.5, 1.0, 4.0}), 3.0);
  EXPECT_EQ(worst_difference(run, std::vector<double>{1.5}), 0.5);
  EXPECT_EQ(worst_difference(std::vector<double>{1.5}, run), 0.5);
  EXPECT_EQ(worst_difference(run, run), 0.0);
}

TEST(Integrators, ANanDifferenceCounts) {
  const std::vector<double> run = {0.0, std::nan("")};
  const std::vector<double> reference = {0.0, 0.0};
  EXPECT_FALSE(worst_difference(run, reference) < 1.0);
  EXPECT_TRUE(std::isnan(worst_difference(std::vector<double>{std::nan(""), 0.1}, reference))) << "nor is it lost behind a number";
}

}  // namespace
}  // namespace hapton
