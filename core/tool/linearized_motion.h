#pragma once

#include "core/tool/placement.h"

namespace hapton {

// A rigid motion in which the path of each point is replaced by the straight line from its start to its end. The true path differs from
// this line by at most the sagitta of its arc. Frame and units: TouchGeometry's local ones; rad. RT: yes.
struct LinearizedMotion {
  Placement from;
  Mat3 orientation;  // at the start
  Vec3 shift;
  Mat3 turn_change;      // turn_change * arm: the change of an arm by the turn, along the scene's axes
  double angle = 0.0;    // of the turn
  double sagitta = 0.0;  // upper bound, for an arm of length 1

  explicit LinearizedMotion(const RigidMotion& motion)
      : from(motion.from),
        orientation(motion.from.orientation.toRotationMatrix()),
        shift(motion.shift),
        turn_change(turn_by(motion.turn).toRotationMatrix() - Mat3::Identity()),
        angle(motion.turn.norm()),
        sagitta(0.125 * angle * angle) {}

  // The displacement from start to end of a point of the tool. arm: from the grip point at the start, along the scene's axes.
  Vec3 displacement(const Vec3& arm) const { return shift + turn_change * arm; }
};

}  // namespace hapton
