#pragma once

#include "core/math/types.h"

namespace hapton {

// The reference space of OpenXR, frame L (y up). local: its origin is where the eyes were when the runtime started or was last recentred.
// stage: its origin is on the floor.
enum class RoomSpace { local, stage };

// The frame O of a viewer: position and heading of the head, without pitch and roll; for stage, on the floor below the head. Returns X_LO.
// X_LH: pose of the head, which looks along -z. Pre: it is rigid.
Pose find_viewer_origin(const Pose& X_LH, RoomSpace space);

// The pose of the workspace in the room, in true size. Frames: L, the space of the runtime; O, the frame of the viewer at the last
// recentre(), before the first one the same as L; W, the world, with its origin in the workspace's centre. Units: metres. RT: no.
class WorkspacePlace {
 public:
  WorkspacePlace(const Pose& X_OW, RoomSpace space) : X_OW_(X_OW), space_(space) {}

  // Places the workspace relative to the viewer as X_OW says, and undoes all moves. X_LH: pose of the head. Pre: it is rigid.
  void recentre(const Pose& X_LH);
  // Moves the viewer relative to the workspace, along the axes of O: the workspace moves in the opposite direction.
  void move_viewer(const Vec3& by_m) { viewer_motion_m_ += by_m; }

  Pose X_LW() const { return X_LO_ * Eigen::Translation3d(-viewer_motion_m_) * X_OW_; }

 private:
  Pose X_OW_;
  RoomSpace space_;
  Pose X_LO_ = Pose::Identity();
  Vec3 viewer_motion_m_ = Vec3::Zero();  // sum of all moves since the last recentre()
};

}  // namespace hapton
