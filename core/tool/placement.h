#pragma once

#include "core/math/rotation_vector.h"
#include "core/math/types.h"

namespace hapton {

// Rows and columns 0..2: translation (shift); 3..5: rotation vector (turn), rad.
using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;

// Pose of the tool: position of its grip point, and orientation, in the frame of the contact computation (local units of the scene). A
// point r of the tool, relative to the grip point in the tool's axes, is at position + orientation * r.
struct Placement {
  Vec3 position = Vec3::Zero();
  Quat orientation = Quat::Identity();

  Vec3 at(const Vec3& r) const { return position + orientation * r; }
  // a.inverse() * b is the placement b, expressed in the frame that has the placement a.
  Placement inverse() const {
    const Quat back = orientation.conjugate();
    return {-(back * position), back};
  }
  friend Placement operator*(const Placement& a, const Placement& b) {
    return {a.at(b.position), (a.orientation * b.orientation).normalized()};
  }
  friend bool operator==(const Placement& a, const Placement& b) {
    return a.position == b.position && a.orientation.coeffs() == b.orientation.coeffs();
  }
};

// Upper bound of how far a point within `radius` of the tool's grip point moves relative to a body that moves from `from` to `to`. RT: yes.
inline double relative_travel_bound(const Placement& tool, double radius, const Placement& from, const Placement& to) noexcept {
  const Placement a = from.inverse() * tool;
  const Placement b = to.inverse() * tool;
  return (b.position - a.position).norm() + radius * turn_between(a.orientation, b.orientation).norm();
}

// A motion of the tool over the times 0..1: its grip point moves on a straight line by `shift`, and the tool turns about that point by
// `turn` (a rotation vector), both at constant rates. RT: yes.
struct RigidMotion {
  Placement from;
  Vec3 shift = Vec3::Zero();
  Vec3 turn = Vec3::Zero();

  Placement at(double time) const noexcept {
    return {from.position + time * shift, (turn_by(time * turn) * from.orientation).normalized()};
  }
  // No point within `radius` of the grip point moves farther than this.
  double length(double radius) const noexcept { return shift.norm() + turn.norm() * radius; }
  RigidMotion scaled(double share) const noexcept { return {from, share * shift, share * turn}; }
  Vec6 shift_and_turn() const noexcept { return (Vec6() << shift, turn).finished(); }
};

inline RigidMotion motion_between(const Placement& from, const Placement& to) noexcept {
  return {from, to.position - from.position, turn_between(from.orientation, to.orientation)};
}

}  // namespace hapton
