#pragma once

#include "core/tool/least_motion.h"
#include "core/tool/placement.h"

namespace hapton {

// The energy of a coupling between two placements of a tool, over its linear stiffness: the squared distance of the grip points plus the
// squared turn times turn_length^2, less what contacts add as their levers turn (multiplier times gap_curvature of each). Its second
// derivative gives coordinates of motions in which it is, to second order, the squared length. RT: yes.
class MotionEnergy {
 public:
  // Pre: 0 < turn_length.
  explicit MotionEnergy(double turn_length) : turn_length_(turn_length) { set_plain(); }

  // From now on the energy is that of the coupling alone.
  void set_plain() noexcept;
  // The second derivative, by shift and turn: that of the coupling, less what contacts add. It is kept within bounds of the coupling's own.
  void set_curvature(const Mat6& curvature) noexcept;
  Mat6 coupling_curvature() const noexcept;

  // How far apart the ends of a motion are: the square root of the coupling's energy.
  double length(const RigidMotion& motion) const noexcept;
  Vec6 to_coordinates(const RigidMotion& motion) const noexcept;
  RigidMotion to_motion(const Placement& from, const Vec6& y) const noexcept;
  // The coordinates of the pose that the coupling pulls to. wanted: the motion from the present pose to that of the device.
  Vec6 goal_of(const RigidMotion& wanted) const noexcept;
  // A gradient by shift and turn, in these coordinates.
  Vec6 to_row(const Vec6& row) const noexcept { return inverse_root_.transpose() * row; }

  double turn_length() const { return turn_length_; }
  // From coordinates to shift and turn.
  const Mat6& inverse_root() const { return inverse_root_; }

 private:
  double turn_length_;
  Mat6 root_;  // root^T root is the second derivative by shift and turn
  Mat6 inverse_root_;
};

}  // namespace hapton
