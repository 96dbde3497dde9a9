#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/math/types.h"
#include "scene/table_reader.h"

namespace hapton {

// One [[object.keyframe]] of a scene file.
struct KeyframeSpec {
  double time_s = 0.0;
  std::optional<Vec3> p_SM = {};  // the object's position_m then; none: its pivot is where it is at rest
  std::optional<Quat> q_SM = {};  // none: as at rest
  std::size_t line = 0;
};

// How an object of a scene file moves: by keyframes, by an animation of its mesh file, by programs, or not at all.
struct MotionSpec {
  std::vector<KeyframeSpec> keyframes;
  Vec3 p_MP = Vec3::Zero();    // pivot_m: of the mesh, m, before scale and pose
  std::string animation = {};  // its name; empty: none
  double animation_speed = 1.0;
  std::size_t animation_line = 0;
  bool loops = false;
  double seam_s = 0.0;      // from the end of an animation that loops back to its first pose, of the file; no key: split_animated sets it
  bool by_program = false;  // moved_by
  double mass_kg = 0.0;     // above 0: it can be pushed

  // By itself.
  bool any() const { return !keyframes.empty() || !animation.empty(); }
  // Where an error of the object's motion is.
  std::size_t line() const { return keyframes.empty() ? animation_line : keyframes.front().line; }
};

// The keys keyframe, pivot_m, animation, animation_speed, loop, moved_by and mass_kg of the table of an object. RT: set-up only. Error: one
// line with the line in the file: fewer than two keyframes, times that do not grow, keys that do not go together.
Result<MotionSpec> read_motion(const toml::table& object, const std::string& name);

}  // namespace hapton
