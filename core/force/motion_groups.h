#pragma once

#include <memory>
#include <vector>

#include "core/force/touch_scene.h"
#include "core/math/keyframe_motion.h"

namespace hapton {

// Objects of a scene that move together, so that one method feels them in one frame.
struct MotionGroup {
  std::shared_ptr<const KeyframeMotion> motion = nullptr;  // null: by commands, or not at all
  std::vector<int> objects = {};                           // of the scene
  bool is_deforming = false;                               // one object
  int commanded = -1;                                      // one object, by commands: its number in MethodInput::commanded; -1: none

  bool is_alone() const { return is_deforming || commanded >= 0; }
  bool moves() const { return motion != nullptr || is_deforming || commanded >= 0; }
};

// What stands still first, if anything does; the others in the order of the scene. RT: no.
std::vector<MotionGroup> group_by_motion(const TouchScene& scene);

// The material of what stands still where it holds against what moves: without friction and damping (TouchChain). RT: yes.
inline Material holding_material(const Material& material) noexcept {
  return {.stiffness_n_per_m = material.stiffness_n_per_m, .two_sided = material.two_sided};
}

}  // namespace hapton
