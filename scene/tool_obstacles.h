#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "core/force/touch_scene.h"
#include "core/tool/contact_damping.h"
#include "core/tool/tool_friction.h"

namespace hapton {

// Objects of a scene that move together by the same keyframes, or one object that programs move.
struct ToolPart {
  std::shared_ptr<const KeyframeMotion> motion = nullptr;
  int commanded = -1;  // the object's number in the scene

  // The pose, frame S, that takes the part from rest to its place by its keyframes; the identity if programs move it. RT: yes.
  Pose pose_at(double time_s) const noexcept { return motion != nullptr ? motion->pose_at(time_s) : Pose(Pose::Identity()); }
};

// What a rigid tool feels of a scene: shapes, friction, damping, viscosity, and effects in free space. ToolStep::make and damp use it, with
// the stiffness for the spring.
struct ToolObstacles {
  std::vector<std::shared_ptr<const TriangleMesh>> meshes;  // frame S, metres, one for each object
  std::vector<CoulombFriction> friction;                    // for each mesh
  std::vector<DampingCoefficients> damping;                 // for each mesh: damping_ns_per_m and viscosity_ns_per_m
  std::vector<int> part_of;             // for each mesh: 0 if it does not move, otherwise the number of its part, counted from 1
  std::vector<ToolPart> parts;          // the parts that move
  std::vector<SwitchedEffect> effects;  // in free space, felt at the grip point
  double stiffness_n_per_m = 0.0;       // of the stiffest surface of the whole scene
  bool leaves_out = false;              // surfaces have images or other effects, or are one-sided, which a tool does not feel

  bool has_friction() const;
  bool has_damping() const;
};

// Whether its surface has images or effects other than viscosity, or is one-sided.
bool has_effects_beyond_tool(const TouchObject& object);

// Makes the obstacles of a tool from a scene; the meshes, at rest, are shared. held: the number of the object that is the tool; its mesh
// and material are not among the obstacles. RT: set-up only. Pre: held is a number of an object; no object deforms.
ToolObstacles make_tool_obstacles(const TouchScene& scene, std::optional<std::size_t> held = std::nullopt);

}  // namespace hapton
