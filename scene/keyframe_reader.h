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
  std::optional<Vec3> p_SM = {};  // position_m of the object at this time; none: its pivot is where it is at rest
  std::optional<Quat> q_SM = {};  // none: its rotation is that at rest
  std::size_t line = 0;           // in the scene file
};

// How an object of a scene file moves: by keyframes, by an animation of its mesh file, by programs, or not at all.
struct MotionSpec {
  std::vector<KeyframeSpec> keyframes;
  Vec3 p_MP = Vec3::Zero();    // pivot_m: in the frame of the mesh, m, before scale and pose
  std::string animation = {};  // the animation's name in the mesh file; empty: none
  double animation_speed = 1.0;
  std::size_t animation_line = 0;
  bool loops = false;
  double seam_s = 0.0;      // time from the end of a looping animation back to its first pose, at speed 1; no key: split_animated sets it
  bool by_program = false;  // moved_by: a program may move it
  double mass_kg = 0.0;     // above 0: it can be pushed; 0: no key

  // Whether it moves by itself.
  bool any() const { return !keyframes.empty() || !animation.empty(); }
  // The line in the scene file that an error about the motion names.
  std::size_t line() const { return keyframes.empty() ? animation_line : keyframes.front().line; }
};

// The keys keyframe, pivot_m, animation, animation_speed, loop, moved_by and mass_kg of an object's table. RT: set-up only. Error: one line
// with the line in the file: too few keyframes, times that do not increase, keys that exclude or need another.
Result<MotionSpec> read_motion(const toml::table& object, const std::string& name);

}  // namespace hapton
