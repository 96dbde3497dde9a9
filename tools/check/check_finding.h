#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/math/types.h"

namespace hapton {

// What can be wrong with a scene before anyone touches it.
enum class SceneFault : std::uint8_t {
  thin_wall,           // thinner than the ball of the probe
  opening,             // a hole that the probe fits through
  crack,               // a gap that was not sealed
  large_fan,           // more triangles at a vertex than a step can follow
  flipped,             // triangles whose fronts are on the wrong side
  inside_out,          // a closed body with its fronts inside
  coincides,           // the same shape in the same place as another object
  enclosed,            // altogether inside another object
  view_inside,         // the camera or a light inside a body
  rough,               // more friction than any surface has
  coarse_voxels,       // of what can be carved, for its walls or for the tool
  no_inertia,          // a body to push whose surface is not closed
  odd_tool,            // a rigid tool far smaller or larger than the scene, or far from where it is held
  shape_alone,         // effects that a rigid tool does not feel
  overlaps,            // a movable object that overlaps or touches another one where it lies
  softer_than_device,  // less force than the friction of the device
  stiffer_than_device,
  stiffer_than_loop,
  tool_stiffer_than_loop,  // turns about its grip
  more_damped_than_loop,
  heavier_than_loop,     // a virtual mass
  stronger_than_device,  // an effect
  faster_than_loop,      // a vibration that the servo rate cannot carry
  out_of_reach,          // all or a part of an object, or an effect, lies outside the workspace
  too_small,             // a speck in the workspace
  too_slow,              // the force takes longer than the loop allows
};
// "thin-wall", "opening" ...
std::string_view name_of(SceneFault fault) noexcept;

struct CheckFinding {
  SceneFault fault = SceneFault::thin_wall;
  std::string object;           // empty: the whole scene
  std::optional<Vec3> place_m;  // frame S
  std::string what;             // how it is, half a line
  std::string fix;              // what to do about it, half a line
  // Into Scene::objects, as objects may have the same name. Of check_places only; none: the whole scene, or of another check.
  std::optional<std::size_t> object_index = {};
};

using CheckFindings = std::vector<CheckFinding>;

}  // namespace hapton
