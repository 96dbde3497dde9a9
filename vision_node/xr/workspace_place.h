#pragma once

#include "core/math/types.h"

namespace hapton {

// Which space of the runtime the workspace stands in: LOCAL has its origin where the eyes were when the runtime started or was last
// recentred, STAGE has it on the floor.
enum class RoomSpace { local, stage };

// Where a viewer is who looks straight ahead: the head's position and its heading, without pitch and roll. stage: on the floor below the
// head. Frame L: the runtime's space, y up. X_LH: the head, looks along -z. Pre: rigid.
Pose find_viewer_origin(const Pose& X_LH, RoomSpace space);

// Where the workspace stands in the room, in true size. Frames: L, the runtime's space (y up, at first the viewer looks along -z); O, where
// the viewer was when the workspace was last recentred, at first L; W, the world, with its origin in the workspace's centre. Units: metres.
// RT: no.
class WorkspacePlace {
 public:
  WorkspacePlace(const Pose& X_OW, RoomSpace space) : X_OW_(X_OW), space_(space) {}

  // Before the viewer as it was at first, and all moves are taken back. Pre: X_LH rigid.
  void recentre(const Pose& X_LH);
  // The viewer is moved by so much, as O has it: the workspace goes the other way.
  void move_viewer(const Vec3& by_m) { moved_m_ += by_m; }

  Pose X_LW() const { return X_LO_ * Eigen::Translation3d(-moved_m_) * X_OW_; }

 private:
  Pose X_OW_;
  RoomSpace space_;
  Pose X_LO_ = Pose::Identity();
  Vec3 moved_m_ = Vec3::Zero();
};

}  // namespace hapton
