#pragma once

#include <optional>

#include "core/geometry/triangle_mesh.h"
#include "core/math/keyframe_motion.h"
#include "scene/scene_fit.h"

namespace hapton {

struct ObjectSpec;

// The place of an object as position_m and rotation of a scene file give it (frame F).
struct ObjectPlace {
  Vec3 p_FM = Vec3::Zero();
  Quat q_FM = Quat::Identity();
};

// An object of a scene that programs may move: converts position_m and rotation of its scene file to a pose in S, and back. RT: all but
// construction. Threads: const calls from any number.
class CommandedObject {
 public:
  // mesh: as touched at rest, in S after `fit`. Pre: object.motion.by_program.
  CommandedObject(const ObjectSpec& object, const SceneFit& fit, const TriangleMesh& mesh);

  // The pivot (`pivot_m` of the scene file) of the object at rest, in frame S.
  const Vec3& pivot() const noexcept { return pivot_S_; }
  // No point of the object is farther than this from the pivot.
  double radius_m() const noexcept { return radius_m_; }

  // The pose of the object with that position_m and rotation. Without p_FM the pivot keeps its position in `now`; without q_FM the object
  // keeps its rotation in `now`. The time of the result is 0. Pre: finite; a rotation of unit length to 1e-3.
  Keyframe place(const std::optional<Vec3>& p_FM, const std::optional<Quat>& q_FM, const Keyframe& now) const noexcept;
  // The inverse of place(): the position_m and rotation that lead to the pose `at`.
  ObjectPlace find_place(const Keyframe& at) const noexcept;

  // Whether pivot, rotations, radius and fit are the same, so that the same requests lead to the same poses.
  bool operator==(const CommandedObject& other) const noexcept;

 private:
  Vec3 p_MP_;  // pivot in the frame of the mesh, scaled
  Quat q_SM_;  // rotation in the scene file, turned by q_SF_
  Quat q_SF_;  // see ObjectSpec
  SceneFit fit_;
  Vec3 pivot_S_;
  double radius_m_;
};

}  // namespace hapton
