#pragma once

#include "core/tool/least_motion.h"
#include "core/tool/placement.h"

namespace hapton {

// Twice the energy of a coupling between two placements of a tool, over its linear stiffness: the squared distance of the grip points plus
// the squared turn times turn_length^2, less the second-order share of contacts whose levers turn (multiplier times gap_curvature of each).
// Defines coordinates y of motions in which it is |y|^2 to second order. Lengths: local units; turn: rotation vector, rad. RT: yes.
class MotionEnergy {
 public:
  // Pre: 0 < turn_length.
  explicit MotionEnergy(double turn_length) : turn_length_(turn_length) { set_plain(); }

  // From now on the energy is that of the coupling alone.
  void set_plain() noexcept;
  // curvature: coupling_curvature() less the share of the contacts. Limited to between 1/8 and 64 times the coupling's own.
  void set_curvature(const Mat6& curvature) noexcept;
  Mat6 coupling_curvature() const noexcept;  // second derivative of the energy over linear stiffness, by shift and turn

  // The length of a motion: the square root of twice the energy of the coupling alone, over its linear stiffness.
  double length(const RigidMotion& motion) const noexcept;
  Vec6 to_coordinates(const RigidMotion& motion) const noexcept;
  RigidMotion to_motion(const Placement& from, const Vec6& y) const noexcept;
  // The coordinates at which the energy would be least without contacts' bounds. wanted: motion from the present pose to the device's.
  Vec6 goal_of(const RigidMotion& wanted) const noexcept;
  // Converts a gradient with respect to shift and turn to these coordinates.
  Vec6 to_row(const Vec6& row) const noexcept { return inverse_root_.transpose() * row; }

  double turn_length() const { return turn_length_; }
  // Multiplied by coordinates, gives shift and turn.
  const Mat6& inverse_root() const { return inverse_root_; }

 private:
  double turn_length_;
  Mat6 root_;  // root^T root is the (limited) curvature by shift and turn
  Mat6 inverse_root_;
};

}  // namespace hapton
