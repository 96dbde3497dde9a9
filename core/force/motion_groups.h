#pragma once

#include <memory>
#include <vector>

#include "core/force/force_method.h"
#include "core/math/keyframe_motion.h"

namespace hapton {

// Objects of a scene that move together, so that one method feels them in one frame.
struct MotionGroup {
  std::shared_ptr<const KeyframeMotion> motion = nullptr;  // null: no keyframes
  std::vector<int> objects = {};                           // indices in the scene
  bool is_deforming = false;                               // the group is one object, and it deforms
  int commanded = -1;                                      // index in MethodInput::commanded if programs may move it; -1: they may not

  bool is_alone() const { return is_deforming || commanded >= 0; }
  bool moves() const { return motion != nullptr || is_deforming || commanded >= 0; }
  // X_SO, the pose of the group at the sample of the input. RT: yes.
  Pose pose_at(const MethodInput& input) const noexcept {
    if (commanded >= 0 && static_cast<std::size_t>(commanded) < input.commanded.size()) {
      return input.commanded[static_cast<std::size_t>(commanded)];
    }
    return motion != nullptr ? motion->pose_at(input.time_s) : Pose(Pose::Identity());
  }
};

// The group that does not move comes first, if there is one; the others in the order of the scene. RT: no.
std::vector<MotionGroup> group_by_motion(const TouchScene& scene);

// The material of an object as a part of the scene renders it while other parts hold the proxy as well (CommonProxy): without static
// friction, and without damping, which the common proxy computes. RT: yes.
inline Material shared_material(Material material) noexcept {
  material.friction_static = material.friction_dynamic;
  material.damping_ns_per_m = 0.0;
  return material;
}

}  // namespace hapton
