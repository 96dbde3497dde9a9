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
  large_fan,           // more than 1000 triangles meet at a vertex, so that steps there take long
  flipped,             // adjacent triangles whose fronts are on opposite sides
  inside_out,          // a closed body whose fronts are on its inside
  coincides,           // the same shape in the same place as another object
  enclosed,            // wholly inside another object, whose surface keeps the probe out
  view_inside,         // the camera or a light is inside a body
  rough,               // more friction than any dry surface has
  coarse_voxels,       // the voxels of an object that can be carved are too large for its walls or for the ball that carves
  no_inertia,          // an object with a mass, whose surface is not closed or faces inwards
  odd_tool,            // a rigid tool far smaller or larger than the scene, or far from where it is held
  shape_alone,         // effects that a rigid tool or a picked-up object does not feel
  overlaps,            // a movable object that overlaps or touches another one where it lies
  softer_than_device,  // a surface that gives less force than the friction of the device
  stiffer_than_device,
  stiffer_than_loop,
  tool_stiffer_than_loop,  // a rigid tool or a picked-up object turns too stiffly about its grip point
  more_damped_than_loop,
  heavier_than_loop,     // a virtual mass that is too large for the loop
  stronger_than_device,  // an effect or a layer with more force than the device can give
  faster_than_loop,      // a vibration that the servo rate cannot carry
  out_of_reach,          // an object, a part of it, or an effect lies outside the workspace
  too_small,             // a speck in the workspace
  too_slow,              // the force takes longer than the loop allows
};
// "thin-wall", "opening" and so on.
std::string_view name_of(SceneFault fault) noexcept;

struct CheckFinding {
  SceneFault fault = SceneFault::thin_wall;
  std::string object;           // empty: the whole scene
  std::optional<Vec3> place_m;  // frame S
  std::string what;             // what was found, half a line
  std::string fix;              // what to do about it, half a line
  // Index into Scene::objects, since names may repeat. Only check_places sets it; none: about the whole scene, or from another check.
  std::optional<std::size_t> object_index = {};
};

using CheckFindings = std::vector<CheckFinding>;

}  // namespace hapton
