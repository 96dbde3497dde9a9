#pragma once

#include <Eigen/Core>

#include "closed_loop/device_model.h"
#include "closed_loop/hand_model.h"

namespace hapton {

// One axis of device and hand as a linear system: a chain of masses and joints, with the motors at the first mass and the hand at the last.
//
//   u -> [amplifier] -> [motor mass] ==joint== [..] ==joint== [last mass + hand mass] ==hand== intended position h
//                           friction f
//
//   state  x0 v0 [x1 v1 [x2 v2]] [force of the amplifier]        inputs  h, h', u, f
//   d/dt state = a state + b inputs;  h' is the rate of h
//
// x0 is the position that the encoder reads. Coulomb friction is an input f here, because it depends on the motion (axis_motion.h). Any
// other force on the motor mass adds to f. Units SI. RT: no.
struct AxisPlant {
  static constexpr int kMaxStates = 2 * (DeviceModel::kMaxModes + 1) + 1;
  static constexpr int kInputs = 4;
  enum Input : int { hand = 0, hand_speed = 1, command = 2, friction = 3 };

  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxStates, kMaxStates>;
  using InputMatrix = Eigen::Matrix<double, Eigen::Dynamic, kInputs, 0, kMaxStates, kInputs>;

  Matrix a;
  InputMatrix b;
  bool has_amplifier = false;

  int states() const noexcept { return static_cast<int>(a.rows()); }
  int masses() const noexcept { return states() / 2; }
};

// Pre: every mass above zero, mode_count within 0..DeviceModel::kMaxModes. A hand without spring and damper is allowed.
AxisPlant make_axis_plant(const DeviceModel& device, const HandModel& hand);

}  // namespace hapton
