#include "devices/stylus_dynamics.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/math/dense_matrix.h"

namespace hapton {
namespace {

constexpr int kX = 0, kV = 1, kY = 2, kW = 3, kHand = 4, kHandSpeed = 5, kForce = 6;
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
      sliding_(make_steps(false)),
      pinned_(make_steps(true)) {}

StylusDynamics::Steps StylusDynamics::make_steps(bool pinned) const {
  const double m = model_.device_mass_kg;
  const double mass = model_.stylus_mass_kg + model_.hand_mass_kg;
  const double k_h = model_.hand_stiffness_n_per_m;
  const double b_h = model_.hand_damping_n_s_per_m;
  Eigen::Matrix<double, 7, 7> a = Eigen::Matrix<double, 7, 7>::Zero();
  if (!pinned) {
    a(kX, kV) = 1.0;
    a(kV, kX) = -k_s_ / m;
    a(kV, kV) = -(model_.device_damping_n_s_per_m + b_s_) / m;
    a(kV, kY) = k_s_ / m;
    a(kV, kW) = b_s_ / m;
    a(kV, kForce) = 1.0 / m;
  }
  a(kY, kW) = 1.0;
  a(kW, kX) = k_s_ / mass;
  a(kW, kV) = b_s_ / mass;
  a(kW, kY) = -(k_s_ + k_h) / mass;
  a(kW, kW) = -(b_s_ + b_h) / mass;
  a(kW, kHand) = k_h / mass;
  a(kW, kHandSpeed) = b_h / mass;
  a(kHand, kHandSpeed) = 1.0;
  Steps steps;
  for (int bit = 0; bit <= kGridBits; ++bit) {
    const Eigen::Matrix<double, 7, 7> over = compute_exponential(a * std::ldexp(1e-9, bit));
    steps[bit] = over.topRows<4>();
  }
  return steps;
}

double StylusDynamics::net_force_n(const Eigen::Vector4d& state, double force_n) const noexcept {
  return force_n + k_s_ * (state[kY] - state[kX]) + b_s_ * (state[kW] - state[kV]) - model_.device_damping_n_s_per_m * state[kV];
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
  bool bracketed = false;
  for (int bit = kGridBits; bit >= 0; --bit) {
    if ((std::int64_t{1} << bit) > left_ns) continue;
    const Eigen::Vector4d next = stepped(bit);
    if (event(next)) {
      bracketed = true;
      if (bit == 0) accept(0, next);
      continue;
    }
    accept(bit, next);
    if (bracketed && bit == 0) accept(0, stepped(0));
  }
  return bracketed;
}

void StylusDynamics::cross_grid_cell(Eigen::Vector4d& state, Input& input, const AxisStops& stops, std::int64_t left_ns) const noexcept {
  const double force_n = input[2];
  const double friction_n = model_.friction_n;
  for (int events = 0; left_ns > 0; ++events) {
    // The forces up to which the device mass is held: friction in both directions, a stop without limit.
    const double hold_up = state[kX] >= stops.high_m ? HUGE_VAL : friction_n;
    const double hold_down = state[kX] <= stops.low_m ? -HUGE_VAL : -friction_n;
    const double net_n = net_force_n(state, force_n);
    const bool at_rest = state[kV] == 0.0;
    if ((at_rest && net_n <= hold_up && net_n >= hold_down) || events >= kMaxEventsPerCell) {
      state[kV] = 0.0;
      const bool may_break = events < kMaxEventsPerCell;
      run(pinned_, state, input, left_ns, [&](const Eigen::Vector4d& s) {
        const double n = net_force_n(s, force_n);
        return may_break && (n > hold_up || n < hold_down);
      });
      continue;
    }
    const double direction = std::copysign(1.0, at_rest ? net_n : state[kV]);
    const double stop_m = direction > 0.0 ? stops.high_m : stops.low_m;
    input[2] = force_n - direction * friction_n;
    const bool stopped = run(sliding_, state, input, left_ns,
                             [&](const Eigen::Vector4d& s) { return direction * s[kV] < 0.0 || direction * (s[kX] - stop_m) > 0.0; });
    input[2] = force_n;
    if (!stopped) return;
    if (direction * (state[kX] - stop_m) >= 0.0) state[kX] = stop_m;
    state[kV] = 0.0;
  }
}

void StylusDynamics::advance(AxisState& axis, const AxisInput& held, const AxisStops& stops, std::int64_t start_ns,
                             std::int64_t duration_ns) const noexcept {
  constexpr std::int64_t kCell = std::int64_t{1} << kGridBits;
  Eigen::Vector4d state(axis.device_m, axis.device_m_per_s, axis.stylus_m, axis.stylus_m_per_s);
  Input input(held.hand_m, held.hand_m_per_s, held.force_n);
  for (std::int64_t now = start_ns, end = start_ns + duration_ns; now < end;) {
    const std::int64_t next = std::min(end, (now / kCell + 1) * kCell);
    cross_grid_cell(state, input, stops, next - now);
    input[0] = held.hand_m + held.hand_m_per_s * 1e-9 * static_cast<double>(next - start_ns);
    now = next;
  }
  axis = {state[kX], state[kV], state[kY], state[kW]};
}

double StylusDynamics::energy_j(const AxisState& s, double hand_m) const noexcept {
  const double mass = model_.stylus_mass_kg + model_.hand_mass_kg;
  const double bend = s.device_m - s.stylus_m;
  const double pull = s.stylus_m - hand_m;
  return 0.5 * (model_.device_mass_kg * s.device_m_per_s * s.device_m_per_s + mass * s.stylus_m_per_s * s.stylus_m_per_s +
                k_s_ * bend * bend + model_.hand_stiffness_n_per_m * pull * pull);
}

}  // namespace hapton
