#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "core/force/touch_scene.h"
#include "core/tool/contact_damping.h"
#include "core/tool/tool_friction.h"

namespace hapton {

// Objects of a scene that move together: by keyframes, or one that programs move.
struct ToolPart {
  std::shared_ptr<const KeyframeMotion> motion = nullptr;
  int commanded = -1;  // the object's number in the scene

  // The pose, frame S, that takes the part from rest to its place by its keyframes; the identity if programs move it. RT: yes.
  Pose pose_at(double time_s) const noexcept { return motion != nullptr ? motion->pose_at(time_s) : Pose(Pose::Identity()); }
};

// What a rigid tool feels of a scene: shapes, friction, damping, viscosity, and effects in free space. ToolStep::make and damp take it,
// with the stiffness for the spring.
struct ToolObstacles {
  std::vector<std::shared_ptr<const TriangleMesh>> meshes;  // frame S, metres, one for each object
  std::vector<CoulombFriction> friction;                    // of each mesh
  std::vector<DampingCoefficients> damping;                 // of each mesh: damping_ns_per_m and viscosity_ns_per_m
  std::vector<int> part_of;                                 // of each mesh: 0 where it stands still, else the part's number, from 1
  std::vector<ToolPart> parts;                              // that move
  std::vector<SwitchedEffect> effects;                      // in free space, felt at the grip point
  double stiffness_n_per_m = 0.0;                           // of the stiffest surface of the whole scene
  bool leaves_out = false;  // surfaces have images, other effects or one side only, which a tool does not feel

  bool has_friction() const;
  bool has_damping() const;
};

// Images, effects of its surface other than viscosity, or one side only.
bool has_effects_beyond_tool(const TouchObject& object);

// The meshes are shared, where they are at rest. held: the number of the object that is the tool itself; its mesh and material are not
// among the obstacles. RT: set-up only. Pre: held is a number of an object; no object deforms.
ToolObstacles make_tool_obstacles(const TouchScene& scene, std::optional<std::size_t> held = std::nullopt);

}  // namespace hapton
