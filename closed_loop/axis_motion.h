#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "closed_loop/axis_plant.h"

namespace hapton {

// The motion of one axis of device and hand (axis_plant.h) with Coulomb friction at the motors. It is exact: between two events (the motor
// mass comes to rest, or breaks away) the system is linear, and its step over 2^k ns is a matrix exponential computed once. An event is
// bracketed to 1 ns by descending through these powers of two. Energies are quadratic in the state, so their integrals are exact as well.
// The method is that of devices/stylus_dynamics.h, for any number of joints, with an amplifier and with energies. Units SI, ns. RT:
// advance() uses no heap; making an AxisMotion is set-up only.
class AxisMotion {
 public:
  static constexpr int kMaxStates = AxisPlant::kMaxStates;
  using StateVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxStates, 1>;

  struct State {
    StateVector x;         // the states of AxisPlant, in its order
    double motor_j = 0.0;  // work of the motor on the device since the start
    double lost_j = 0.0;   // energy dissipated in the device since the start: viscous damping, joints, friction

    double position_m() const noexcept { return x[0]; }
    double velocity_m_per_s() const noexcept { return x[1]; }
  };

  // Inputs that are constant over an interval, except for the motion of the hand.
  struct Input {
    double command_n = 0.0;
    double hand_m = 0.0;        // intended position of the hand at the start of the interval
    double hand_m_per_s = 0.0;  // velocity of the intended position during the interval
    double push_n = 0.0;        // external force on the motor mass
  };

  AxisMotion(const DeviceModel& device, const HandModel& hand);

  // The state in which all masses rest at this position.
  State rest_at(double position_m) const;
  // Pre: duration_ns >= 0.
  void advance(State& state, const Input& input, std::int64_t duration_ns) const noexcept;
  // Kinetic and elastic energy of device and hand, where hand_m is the intended position of the hand.
  double stored_j(const State& state, double hand_m) const noexcept;

  const AxisPlant& plant() const noexcept { return plant_; }

 private:
  static constexpr int kMaxBits = 31;  // steps of up to 2^30 ns, a second
  static constexpr int kMaxAugmented = kMaxStates + AxisPlant::kInputs;
  using AugmentedState = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxAugmented, 1>;  // states and inputs
  using AugmentedMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxAugmented, kMaxAugmented>;

  // One step of 2^k ns: its transition, and the integrals of motor power and of heat over it as quadratic forms.
  struct Step {
    AugmentedMatrix transition;
    AugmentedMatrix motor_work_form;
    AugmentedMatrix lost_energy_form;
  };
  using Steps = std::array<Step, kMaxBits>;

  Steps make_steps(bool pinned) const;
  AugmentedMatrix motor_power() const;
  AugmentedMatrix dissipated_power() const;
  double net_force_n(const AugmentedState& augmented) const noexcept { return net_force_.dot(augmented); }
  template <class Event>
  bool run(const Steps& steps, State& state, AugmentedState& augmented, std::int64_t& remaining_ns, Event event) const noexcept;
  void cross_cell(State& state, AugmentedState& augmented, std::int64_t remaining_ns) const noexcept;

  DeviceModel device_;
  HandModel hand_;
  AxisPlant plant_;
  int states_;
  int cell_bits_ = kMaxBits - 1;  // events are searched for in cells of 2^cell_bits_ ns
  AugmentedState net_force_;      // its product with states and inputs: the force on the motor mass, friction left out
  Steps sliding_;                 // the motor mass moves
  Steps pinned_;                  // friction holds the motor mass
};

}  // namespace hapton
