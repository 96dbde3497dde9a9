#pragma once

#include "core/tool/placement.h"

namespace hapton {

// A rigid motion with the paths of its points taken as straight lines from start to end. A path stays within the sagitta of its arc of that
// line. Frame and units: TouchGeometry's local ones; rad. RT: yes.
struct LinearizedMotion {
  Placement from;
  Mat3 orientation;  // at the start
  Vec3 shift;
  Mat3 turned;           // what the turn adds to an arm, along the scene's axes
  double angle = 0.0;    // of the turn
  double sagitta = 0.0;  // of an arm of length 1

  explicit LinearizedMotion(const RigidMotion& motion)
      : from(motion.from),
        orientation(motion.from.orientation.toRotationMatrix()),
        shift(motion.shift),
        turned(turn_by(motion.turn).toRotationMatrix() - Mat3::Identity()),
        angle(motion.turn.norm()),
        sagitta(0.125 * angle * angle) {}

  // From start to end, of a point of the tool with an arm along the scene's axes.
  Vec3 displacement(const Vec3& arm) const { return shift + turned * arm; }
};

}  // namespace hapton
