#include "closed_loop/integrators.h"

#include <algorithm>
#include <cmath>

namespace hapton {
namespace {

// The motion of run_press(): the hand starts above the wall and moves into it.
constexpr double kStartM = 0.001;    // above the wall
constexpr double kDepthM = 0.010;    // depth below the surface at which the hand stops
constexpr double kSpeedMPerS = 0.2;  // a fast tap

}  // namespace

std::string_view to_string(Integrator integrator) noexcept {
  switch (integrator) {
    case Integrator::exact:
      return "exact";
    case Integrator::runge_kutta:
      return "runge_kutta_4";
    case Integrator::semi_implicit_euler:
      return "semi_implicit_euler";
  }
  return "";
}

SteppedMotion::SteppedMotion(const DeviceModel& device, const HandModel& hand, Integrator integrator, std::int64_t step_ns)
    : plant_(make_axis_plant(device, hand)), friction_n_(device.friction_n), integrator_(integrator), step_ns_(step_ns) {}

AxisMotion::StateVector SteppedMotion::rate(const AxisMotion::StateVector& state, const AxisMotion::Input& input, double since_s,
                                            double friction_n) const noexcept {
  const double hand_m = input.hand_m + since_s * input.hand_m_per_s;
  return plant_.a * state + plant_.b * Eigen::Vector4d(hand_m, input.hand_m_per_s, input.command_n, input.push_n + friction_n);
}

// Whether the mass is at rest and remains so: Coulomb friction is at least as large as all other forces together.
bool SteppedMotion::remains_at_rest(const AxisMotion::StateVector& state, const AxisMotion::Input& input, double since_s) const noexcept {
  if (friction_n_ == 0.0 || state[1] != 0.0) return false;
  const double net_n = rate(state, input, since_s, 0.0)[1] / plant_.b(1, AxisPlant::friction);
  return std::fabs(net_n) <= friction_n_;
}

void SteppedMotion::step(AxisMotion::StateVector& state, const AxisMotion::Input& input, double since_s) const noexcept {
  const double h = 1e-9 * static_cast<double>(step_ns_);
  const bool is_held = remains_at_rest(state, input, since_s);
  const double free_acceleration = rate(state, input, since_s, 0.0)[1];
  const double direction = state[1] != 0.0 ? std::copysign(1.0, state[1]) : std::copysign(1.0, free_acceleration);
  const auto slope = [&](const AxisMotion::StateVector& at, double after_s) {
    AxisMotion::StateVector d = rate(at, input, since_s + after_s, friction_n_ == 0.0 ? 0.0 : -direction * friction_n_);
    if (is_held) d[0] = d[1] = 0.0;
    return d;
  };
  const AxisMotion::StateVector start_state = state;
  if (integrator_ == Integrator::runge_kutta) {
    const AxisMotion::StateVector k1 = slope(state, 0.0);
    const AxisMotion::StateVector k2 = slope(state + 0.5 * h * k1, 0.5 * h);
    const AxisMotion::StateVector k3 = slope(state + 0.5 * h * k2, 0.5 * h);
    const AxisMotion::StateVector k4 = slope(state + h * k3, h);
    state += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
  } else {
    // Velocities first, then positions with the new velocities.
    const AxisMotion::StateVector k = slope(state, 0.0);
    const int masses = plant_.masses();
    for (int i = 0; i < masses; ++i) state[2 * i + 1] += h * k[2 * i + 1];
    for (int i = 0; i < masses; ++i) state[2 * i] += h * state[2 * i + 1];
    if (plant_.has_amplifier) state[plant_.states() - 1] += h * k[plant_.states() - 1];
  }
  if (friction_n_ > 0.0 && direction * state[1] < 0.0 && start_state[1] != 0.0) state[1] = 0.0;
}

void SteppedMotion::advance(AxisMotion::StateVector& state, const AxisMotion::Input& input, std::int64_t duration_ns) const noexcept {
  for (std::int64_t since_ns = 0; since_ns < duration_ns; since_ns += step_ns_) step(state, input, 1e-9 * static_cast<double>(since_ns));
}

std::vector<double> run_press(const IntegratorCase& press, Integrator integrator, std::int64_t step_ns) {
  const AxisMotion exact(press.device, press.hand);
  const SteppedMotion stepped(press.device, press.hand, integrator, step_ns);
  AxisMotion::State state = exact.rest_at(kStartM);
  const auto count = static_cast<std::int64_t>(1e9 * press.seconds / static_cast<double>(press.period_ns));
  std::vector<double> positions;
  for (std::int64_t k = 0; k < count; ++k) {
    const double now_s = 1e-9 * static_cast<double>(k * press.period_ns);
    const double goal_m = std::max(kStartM - kSpeedMPerS * now_s, -kDepthM);
    const bool moves = goal_m > -kDepthM;
    positions.push_back(state.position_m());
    const AxisMotion::Input input{
        .command_n = press.wall_n_per_m * std::max(0.0, -state.position_m()), .hand_m = goal_m, .hand_m_per_s = moves ? -kSpeedMPerS : 0.0};
    if (integrator == Integrator::exact) {
      exact.advance(state, input, press.period_ns);
    } else {
      stepped.advance(state.x, input, press.period_ns);
    }
  }
  return positions;
}

double worst_difference(std::span<const double> run, std::span<const double> reference) noexcept {
  double worst = 0.0;
  for (std::size_t i = 0; i < std::min(run.size(), reference.size()); ++i) {
    const double difference = std::fabs(run[i] - reference[i]);
    if (std::isnan(difference)) return difference;
    worst = std::max(worst, difference);
  }
  return worst;
}

}  // namespace hapton
