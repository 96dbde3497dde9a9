#pragma once

#include "core/math/rotation_vector.h"
#include "core/math/types.h"

namespace hapton {

using Mat6 = Eigen::Matrix<double, 6, 6>;  // of a shift and a turn, in this order

// Where the tool is: its grip point and its orientation, in the frame of the contact computation (local units of the scene). A point r of
// the tool, from the grip point along the tool's axes, is at position + orientation * r.
struct Placement {
  Vec3 position = Vec3::Zero();
  Quat orientation = Quat::Identity();

  Vec3 at(const Vec3& r) const { return position + orientation * r; }
};

// A motion of the tool over the times 0..1: its grip point moves straight by `shift`, and it turns about that point by `turn` (a rotation
// vector) at a constant rate. RT: yes.
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
};

}  // namespace hapton
