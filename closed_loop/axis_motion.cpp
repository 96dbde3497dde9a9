#include "closed_loop/axis_motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/math/dense_matrix.h"

namespace hapton {
namespace {

constexpr int kMaxEventsPerCell = 16;  // as in StylusDynamics; after these the mass rests until the next cell
// Cells (see cell_bits_) in one period of the fastest motion, or in 2 pi of its time constants; a free choice. An event that begins and
// ends within a cell is missed.
constexpr double kCellsPerPeriod = 100.0;

}  // namespace

AxisMotion::AxisMotion(const DeviceModel& device, const HandModel& hand)
    : device_(device), hand_(hand), plant_(make_axis_plant(device, hand)), states_(plant_.states()) {
  net_force_.setZero(states_ + AxisPlant::kInputs);
  net_force_ << plant_.a.row(1).transpose(), plant_.b.row(1).transpose();
  // The row gives the acceleration; divided by the inverse mass, it gives the net force.
  net_force_ /= plant_.b(1, AxisPlant::friction);
  if (device.friction_n > 0.0) {
    const double fastest = std::max(1e-3, compute_eigenvalues(plant_.a).cwiseAbs().maxCoeff());
    const double cell_ns = 1e9 * 2.0 * std::numbers::pi / (kCellsPerPeriod * fastest);
    cell_bits_ = std::clamp(static_cast<int>(std::log2(cell_ns)), 4, 20);  // 16 ns to 1 ms
  }
  sliding_ = make_steps(false);
  pinned_ = make_steps(true);
}

AxisMotion::AugmentedMatrix AxisMotion::motor_power() const {
  AugmentedMatrix power = AugmentedMatrix::Zero(states_ + AxisPlant::kInputs, states_ + AxisPlant::kInputs);
  const int force = plant_.has_amplifier ? states_ - 1 : states_ + AxisPlant::command;
  power(1, force) = power(force, 1) = 0.5;
  return power;
}

AxisMotion::AugmentedMatrix AxisMotion::dissipated_power() const {
  AugmentedMatrix power = AugmentedMatrix::Zero(states_ + AxisPlant::kInputs, states_ + AxisPlant::kInputs);
  power(1, 1) = device_.damping_ns_per_m;
  for (int i = 0; i + 1 < plant_.masses(); ++i) {
    const double damping = device_.modes[static_cast<std::size_t>(i)].damping_ns_per_m;
    const int here = 2 * i + 1;
    const int there = here + 2;
    power(here, here) += damping;
    power(there, there) += damping;
    power(here, there) -= damping;
    power(there, here) -= damping;
  }
  return power;
}

AxisMotion::Steps AxisMotion::make_steps(bool pinned) const {
  const int n = states_ + AxisPlant::kInputs;
  Eigen::MatrixXd rate = Eigen::MatrixXd::Zero(n, n);
  rate.topLeftCorner(states_, states_) = plant_.a;
  rate.topRightCorner(states_, AxisPlant::kInputs) = plant_.b;
  rate(states_ + AxisPlant::hand, states_ + AxisPlant::hand_speed) = 1.0;
  if (pinned) rate.topRows(2).setZero();
  Steps steps;
  for (int bit = 0; bit < kMaxBits; ++bit) {
    steps[bit].transition = compute_exponential(rate * std::ldexp(1e-9, bit));
    // Set without the rounding of the exponential: what is pinned does not move.
    if (pinned) steps[bit].transition.topRows(2) = AugmentedMatrix::Identity(n, n).topRows(2);
  }
  // In 1 ns the state changes too little to matter for the energies. Over twice a time, an energy is the sum over both halves.
  steps[0].motor_work_form = 1e-9 * motor_power();
  steps[0].lost_energy_form = 1e-9 * dissipated_power();
  for (int bit = 1; bit < kMaxBits; ++bit) {
    const Step& half = steps[bit - 1];
    steps[bit].motor_work_form = half.motor_work_form + half.transition.transpose() * half.motor_work_form * half.transition;
    steps[bit].lost_energy_form = half.lost_energy_form + half.transition.transpose() * half.lost_energy_form * half.transition;
  }
  return steps;
}

AxisMotion::State AxisMotion::rest_at(double position_m) const {
  State state;
  state.x.setZero(states_);
  for (int i = 0; i < plant_.masses(); ++i) state.x[2 * i] = position_m;
  return state;
}

// Advances until remaining_ns is used up (returns false), or until event(augmented) has become true within the last 1 ns (returns true).
template <class Event>
bool AxisMotion::run(const Steps& steps, State& state, AugmentedState& augmented, std::int64_t& remaining_ns, Event event) const noexcept {
  const auto accept = [&](int bit, const AugmentedState& next) {
    const double motor_j = augmented.dot(steps[bit].motor_work_form * augmented);
    const double lost_j = augmented.dot(steps[bit].lost_energy_form * augmented);
    state.motor_j += motor_j;
    state.lost_j += lost_j;
    augmented = next;
    remaining_ns -= std::int64_t{1} << bit;
  };
  bool is_bracketed = false;
  for (int bit = cell_bits_; bit >= 0; --bit) {
    if ((std::int64_t{1} << bit) > remaining_ns) continue;
    const AugmentedState next = steps[bit].transition * augmented;
    if (event(next)) {
      is_bracketed = true;
      if (bit == 0) accept(0, next);
      continue;
    }
    accept(bit, next);
    if (is_bracketed && bit == 0) accept(0, steps[0].transition * augmented);
  }
  return is_bracketed;
}

// The friction input of `augmented` holds the external push; while the mass slides, friction is added to it.
void AxisMotion::cross_cell(State& state, AugmentedState& augmented, std::int64_t remaining_ns) const noexcept {
  const int friction_index = states_ + AxisPlant::friction;
  const double push_n = augmented[friction_index];
  const double friction_n = device_.friction_n;
  for (int events = 0; remaining_ns > 0; ++events) {
    const double net_n = net_force_n(augmented);
    const bool at_rest = augmented[1] == 0.0;
    const bool may_break = events < kMaxEventsPerCell;
    if ((at_rest && std::fabs(net_n) <= friction_n) || !may_break) {
      augmented[1] = 0.0;
      run(pinned_, state, augmented, remaining_ns,
          [&](const AugmentedState& next) { return may_break && std::fabs(net_force_n(next)) > friction_n; });
      continue;
    }
    const double direction = std::copysign(1.0, at_rest ? net_n : augmented[1]);
    const double before_m = augmented[0];
    augmented[friction_index] = push_n - direction * friction_n;
    const bool has_stopped =
        run(sliding_, state, augmented, remaining_ns, [&](const AugmentedState& next) { return direction * next[1] < 0.0; });
    augmented[friction_index] = push_n;
    state.lost_j += friction_n * std::fabs(augmented[0] - before_m);
    if (has_stopped) augmented[1] = 0.0;
  }
}

void AxisMotion::advance(State& state, const Input& input, std::int64_t duration_ns) const noexcept {
  AugmentedState augmented(states_ + AxisPlant::kInputs);
  augmented << state.x, input.hand_m, input.hand_m_per_s, input.command_n, input.push_n;
  const std::int64_t cell_ns = std::int64_t{1} << cell_bits_;
  while (duration_ns > 0) {
    std::int64_t part_ns = std::min(duration_ns, cell_ns);
    duration_ns -= part_ns;
    if (device_.friction_n > 0.0) {
      cross_cell(state, augmented, part_ns);
    } else {
      run(sliding_, state, augmented, part_ns, [](const AugmentedState&) { return false; });
    }
  }
  state.x = augmented.head(states_);
}

double AxisMotion::stored_j(const State& state, double hand_m) const noexcept {
  const int masses = plant_.masses();
  double twice_energy_j = 0.0;
  for (int i = 0; i < masses; ++i) {
    double mass_kg = i == 0 ? device_.motor_mass_kg() : device_.modes[static_cast<std::size_t>(i - 1)].mass_kg;
    if (i == masses - 1) mass_kg += hand_.mass_kg;
    twice_energy_j += mass_kg * state.x[2 * i + 1] * state.x[2 * i + 1];
    if (i + 1 == masses) continue;
    const double bend_m = state.x[2 * i] - state.x[2 * i + 2];
    twice_energy_j += device_.modes[static_cast<std::size_t>(i)].stiffness_n_per_m * bend_m * bend_m;
  }
  const double pull_m = state.x[2 * masses - 2] - hand_m;
  return 0.5 * (twice_energy_j + hand_.stiffness_n_per_m * pull_m * pull_m);
}

}  // namespace hapton
