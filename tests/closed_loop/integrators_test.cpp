#include "closed_loop/integrators.h"

#include <gtest/gtest.h>

#include <cmath>

namespace hapton {
namespace {

double error_of(const IntegratorCase& press, Integrator integrator, std::int64_t step_ns, const std::vector<double>& reference) {
  return worst_difference(run_press(press, integrator, step_ns), reference);
}

// Without friction: halving the step divides the error by 2 and by 16, and the exact motion is what both converge to.
TEST(Integrators, ConvergeWithTheirOrderToTheExactMotion) {
  const IntegratorCase press{.device = find_device_preset("premium-1.5")->model.with_modes(1), .hand = *find_hand_preset("stylus")};
  IntegratorCase smooth = press;
  smooth.device.friction_n = 0.0;
  const std::vector<double> exact = run_press(smooth, Integrator::exact, 1);
  const double euler = error_of(smooth, Integrator::semi_implicit_euler, 10'000, exact);
  EXPECT_NEAR(euler / error_of(smooth, Integrator::semi_implicit_euler, 5'000, exact), 2.0, 0.1);
  const double runge = error_of(smooth, Integrator::runge_kutta, 500'000, exact);
  EXPECT_NEAR(runge / error_of(smooth, Integrator::runge_kutta, 250'000, exact), 16.0, 3.0);
  EXPECT_LT(error_of(smooth, Integrator::runge_kutta, 5'000, exact), 1e-10);
}

TEST(Integrators, WithFrictionTheExactMotionIsWhatFineStepsApproach) {
  const IntegratorCase press{.device = find_device_preset("touch")->model, .hand = *find_hand_preset("stylus")};
  const std::vector<double> exact = run_press(press, Integrator::exact, 1);
  const double coarse = error_of(press, Integrator::runge_kutta, 200'000, exact);
  const double fine = error_of(press, Integrator::runge_kutta, 500, exact);
  EXPECT_LT(fine, 0.1 * coarse);
  EXPECT_LT(fine, 1e-9);
}

TEST(Integrators, ADifferenceThatIsNoNumberCounts) {
  const std::vector<double> run = {0.0, std::nan("")};
  const std::vector<double> reference = {0.0, 0.0};
  EXPECT_FALSE(worst_difference(run, reference) < 1.0);
}

}  // namespace
}  // namespace hapton
