#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace hapton {

// The mechanics of one axis of a PHANToM held by a hand:
//
//   force u -> [device mass m] ==k_s,b_s== [stylus + hand mass M] ==k_h,b_h== intended position h
//               b_d, Coulomb f_c, end stops
//
//   m x''  = u - b_d x' - k_s (x - y) - b_s (x' - y') - f_c sign(x')
//   M y''  = k_s (x - y) + b_s (x' - y') - k_h (y - h) - b_h (y' - h')
//
// The encoders sit on the motors, so x is the position a program reads. k_s is the HP memo's "constrained, small amplitude
// mechanical bandwidth" of 30 Hz: with the stylus held still the device mass rings at sqrt(k_s / m) = 2 pi 30 Hz and passes no
// faster force on. 70 g give k_s = 2.5 N/mm; the Premium 1.5 data sheet says 3.5 N/mm, 34 Hz: the same machine.
// Friction and mass are from that data sheet (0.04 N; below 75 g: here 70 g at the motors and 5 g of stylus). b_s has no source; it is a
// choice of light damping. The hand is a stylus grip: studies of closed loops use 0.1-0.2 kg, 2-10 Ns/m, 200-1000 N/m.
struct StylusModel {
  double device_mass_kg = 0.070;
  double device_damping_n_s_per_m = 0.1;
  double friction_n = 0.04;
  double structure_hz = 30.0;
  double structure_damping_ratio = 0.2;
  double stylus_mass_kg = 0.005;
  double hand_mass_kg = 0.15;
  double hand_damping_n_s_per_m = 6.0;
  double hand_stiffness_n_per_m = 400.0;

  double structure_stiffness_n_per_m() const;
  double structure_damping_n_s_per_m() const;
};

struct AxisState {
  double device_m = 0.0;
  double device_m_per_s = 0.0;  // exactly 0 when friction or a stop holds it
  double stylus_m = 0.0;
  double stylus_m_per_s = 0.0;
};

// The inputs of an axis over an interval: a constant force, and an intended position that moves at constant speed.
struct AxisInput {
  double force_n = 0.0;
  double hand_m = 0.0;  // at the start of the interval
  double hand_m_per_s = 0.0;
};

struct AxisStops {
  double low_m = 0.0;
  double high_m = 0.0;
};

// Integrates one axis exactly: between two events (the device mass comes to rest, breaks away, meets a stop) the system is linear,
// and its step over 2^k ns is a matrix exponential computed once. An event is found by descending through these powers of two
// until it is bracketed by 1 ns. Stops are inelastic. Apart from rounding and this 1 ns, the result does not depend on how an interval is
// split into calls.
// RT: advance yes (bounded); making one is set-up only.
class StylusDynamics {
 public:
  explicit StylusDynamics(const StylusModel& model);

  // Advances the state by duration_ns from start_ns. Pre: both >= 0. start_ns places the interval on a fixed time grid of 65 us, on which
  // events are searched: less than a hundredth of the fastest period.
  void advance(AxisState& state, const AxisInput& input, const AxisStops& stops, std::int64_t start_ns,
               std::int64_t duration_ns) const noexcept;

  // Kinetic and elastic energy (J) with the hand's intention at hand_m.
  double energy_j(const AxisState& state, double hand_m) const noexcept;

  const StylusModel& model() const noexcept { return model_; }

 private:
  static constexpr int kGridBits = 16;            // 2^16 ns: 65.5 us
  using Input = Eigen::Vector3d;                  // hand position, hand speed, force on the device mass
  using Step = Eigen::Matrix<double, 4, 7>;       // [state transition | input response]
  using Steps = std::array<Step, kGridBits + 1>;  // over 2^k ns

  Steps make_steps(bool is_pinned) const;
  double net_force_n(const Eigen::Vector4d& state, double force_n) const noexcept;
  template <class Event>
  bool run(const Steps& steps, Eigen::Vector4d& state, Input& input, std::int64_t& left_ns, Event event) const noexcept;
  void cross_grid_cell(Eigen::Vector4d& state, Input& input, const AxisStops& stops, std::int64_t left_ns) const noexcept;

  StylusModel model_;
  double k_s_ = 0.0;
  double b_s_ = 0.0;
  Steps sliding_steps_;
  Steps pinned_steps_;
};

}  // namespace hapton
