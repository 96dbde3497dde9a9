#pragma once

#include <optional>

#include "core/geometry/triangle_mesh.h"
#include "core/math/keyframe_motion.h"
#include "scene/scene_fit.h"

namespace hapton {

struct ObjectSpec;

// As position_m and rotation of a scene file (frame F).
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

  // At rest, frame S: `pivot_m` of the scene file.
  const Vec3& pivot() const noexcept { return pivot_S_; }
  // No point of the object is farther from the pivot.
  double radius_m() const noexcept { return radius_m_; }

  // Where the object is with that position_m and rotation; what is not given stays as it is now: the pivot's position, and the rotation.
  // The time of the result is 0. Pre: finite; a rotation of unit length to 1e-3.
  Keyframe place(const std::optional<Vec3>& p_FM, const std::optional<Quat>& q_FM, const Keyframe& now) const noexcept;
  // The inverse: what place() puts there.
  ObjectPlace find_place(const Keyframe& at) const noexcept;

  // The same pivot, radius and fit, and the same requests lead to the same places.
  bool operator==(const CommandedObject& other) const noexcept;

 private:
  Vec3 p_MP_;  // pivot, frame of the mesh, scaled
  Quat q_SM_;  // of the scene file, turned
  Quat q_SF_;  // as ObjectSpec has it
  SceneFit fit_;
  Vec3 pivot_S_;
  double radius_m_;
};

}  // namespace hapton
