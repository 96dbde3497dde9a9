#include "devices/stylus_dynamics.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/math/dense_matrix.h"

namespace hapton {
namespace {

constexpr int kDevice = 0, kDeviceSpeed = 1, kStylus = 2, kStylusSpeed = 3, kHand = 4, kHandSpeed = 5, kForce = 6;
// Two or three events are expected in a cell, under 1/100 of the fastest period. If rounding repeats them, the mass rests until its end.
constexpr int kMaxEventsPerCell = 16;

}  // namespace

double StylusModel::structure_stiffness_n_per_m() const {
  const double omega = 2.0 * std::numbers::pi * structure_hz;
  return device_mass_kg * omega * omega;
}

double StylusModel::structure_damping_n_s_per_m() const {
  return 2.0 * structure_damping_ratio * device_mass_kg * 2.0 * std::numbers::pi * structure_hz;
}

StylusDynamics::StylusDynamics(const StylusModel& model)
    : model_(model),
      k_s_(model.structure_stiffness_n_per_m()),
      b_s_(model.structure_damping_n_s_per_m()),
      sliding_steps_(make_steps(false)),
      pinned_steps_(make_steps(true)) {}

StylusDynamics::Steps StylusDynamics::make_steps(bool is_pinned) const {
  const double m = model_.device_mass_kg;
  const double mass = model_.stylus_mass_kg + model_.hand_mass_kg;
  const double k_h = model_.hand_stiffness_n_per_m;
  const double b_h = model_.hand_damping_n_s_per_m;
  Eigen::Matrix<double, 7, 7> a = Eigen::Matrix<double, 7, 7>::Zero();
  if (!is_pinned) {
    a(kDevice, kDeviceSpeed) = 1.0;
    a(kDeviceSpeed, kDevice) = -k_s_ / m;
    a(kDeviceSpeed, kDeviceSpeed) = -(model_.device_damping_n_s_per_m + b_s_) / m;
    a(kDeviceSpeed, kStylus) = k_s_ / m;
    a(kDeviceSpeed, kStylusSpeed) = b_s_ / m;
    a(kDeviceSpeed, kForce) = 1.0 / m;
  }
  a(kStylus, kStylusSpeed) = 1.0;
  a(kStylusSpeed, kDevice) = k_s_ / mass;
  a(kStylusSpeed, kDeviceSpeed) = b_s_ / mass;
  a(kStylusSpeed, kStylus) = -(k_s_ + k_h) / mass;
  a(kStylusSpeed, kStylusSpeed) = -(b_s_ + b_h) / mass;
  a(kStylusSpeed, kHand) = k_h / mass;
  a(kStylusSpeed, kHandSpeed) = b_h / mass;
  a(kHand, kHandSpeed) = 1.0;
  Steps steps;
  for (int bit = 0; bit <= kGridBits; ++bit) {
    const Eigen::Matrix<double, 7, 7> transition = compute_exponential(a * std::ldexp(1e-9, bit));
    steps[bit] = transition.topRows<4>();
  }
  return steps;
}

double StylusDynamics::net_force_n(const Eigen::Vector4d& state, double force_n) const noexcept {
  return force_n + k_s_ * (state[kStylus] - state[kDevice]) + b_s_ * (state[kStylusSpeed] - state[kDeviceSpeed]) -
         model_.device_damping_n_s_per_m * state[kDeviceSpeed];
}

// Goes on until left_ns is used up (false) or event(state) has become true within the last 1 ns (true).
template <class Event>
bool StylusDynamics::run(const Steps& steps, Eigen::Vector4d& state, Input& input, std::int64_t& left_ns, Event event) const noexcept {
  const auto stepped = [&](int bit) -> Eigen::Vector4d { return steps[bit].leftCols<4>() * state + steps[bit].rightCols<3>() * input; };
  const auto accept = [&](int bit, const Eigen::Vector4d& next) {
    state = next;
    input[0] += input[1] * std::ldexp(1e-9, bit);
    left_ns -= std::int64_t{1} << bit;
  };
  bool is_bracketed = false;
  for (int bit = kGridBits; bit >= 0; --bit) {
    if ((std::int64_t{1} << bit) > left_ns) continue;
    const Eigen::Vector4d next = stepped(bit);
    if (event(next)) {
      is_bracketed = true;
      if (bit == 0) accept(0, next);
      continue;
    }
    accept(bit, next);
    if (is_bracketed && bit == 0) accept(0, stepped(0));
  }
  return is_bracketed;
}

void StylusDynamics::cross_grid_cell(Eigen::Vector4d& state, Input& input, const AxisStops& stops, std::int64_t left_ns) const noexcept {
  const double force_n = input[2];
  const double friction_n = model_.friction_n;
  for (int events = 0; left_ns > 0; ++events) {
    // The forces up to which the device mass is held: friction in both directions, a stop without limit.
    const double max_held_n = state[kDevice] >= stops.high_m ? HUGE_VAL : friction_n;
    const double min_held_n = state[kDevice] <= stops.low_m ? -HUGE_VAL : -friction_n;
    const double net_n = net_force_n(state, force_n);
    const bool is_at_rest = state[kDeviceSpeed] == 0.0;
    if ((is_at_rest && net_n <= max_held_n && net_n >= min_held_n) || events >= kMaxEventsPerCell) {
      state[kDeviceSpeed] = 0.0;
      const bool may_break = events < kMaxEventsPerCell;
      run(pinned_steps_, state, input, left_ns, [&](const Eigen::Vector4d& s) {
        const double n = net_force_n(s, force_n);
        return may_break && (n > max_held_n || n < min_held_n);
      });
      continue;
    }
    const double direction = std::copysign(1.0, is_at_rest ? net_n : state[kDeviceSpeed]);
    const double stop_m = direction > 0.0 ? stops.high_m : stops.low_m;
    input[2] = force_n - direction * friction_n;
    const bool is_stopped = run(sliding_steps_, state, input, left_ns, [&](const Eigen::Vector4d& s) {
      return direction * s[kDeviceSpeed] < 0.0 || direction * (s[kDevice] - stop_m) > 0.0;
    });
    input[2] = force_n;
    if (!is_stopped) return;
    if (direction * (state[kDevice] - stop_m) >= 0.0) state[kDevice] = stop_m;
    state[kDeviceSpeed] = 0.0;
  }
}

void StylusDynamics::advance(AxisState& axis, const AxisInput& axis_input, const AxisStops& stops, std::int64_t start_ns,
                             std::int64_t duration_ns) const noexcept {
  constexpr std::int64_t kCell = std::int64_t{1} << kGridBits;
  Eigen::Vector4d state(axis.device_m, axis.device_m_per_s, axis.stylus_m, axis.stylus_m_per_s);
  Input input(axis_input.hand_m, axis_input.hand_m_per_s, axis_input.force_n);
  for (std::int64_t now = start_ns, end = start_ns + duration_ns; now < end;) {
    const std::int64_t next = std::min(end, (now / kCell + 1) * kCell);
    cross_grid_cell(state, input, stops, next - now);
    input[0] = axis_input.hand_m + axis_input.hand_m_per_s * 1e-9 * static_cast<double>(next - start_ns);
    now = next;
  }
  axis = {state[kDevice], state[kDeviceSpeed], state[kStylus], state[kStylusSpeed]};
}

double StylusDynamics::energy_j(const AxisState& s, double hand_m) const noexcept {
  const double mass = model_.stylus_mass_kg + model_.hand_mass_kg;
  const double bend = s.device_m - s.stylus_m;
  const double pull = s.stylus_m - hand_m;
  return 0.5 * (model_.device_mass_kg * s.device_m_per_s * s.device_m_per_s + mass * s.stylus_m_per_s * s.stylus_m_per_s +
                k_s_ * bend * bend + model_.hand_stiffness_n_per_m * pull * pull);
}

}  // namespace hapton
