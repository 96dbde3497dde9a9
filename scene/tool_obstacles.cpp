#include "scene/tool_obstacles.h"

#include <algorithm>

#include "core/force/stiffest.h"

namespace hapton {

bool ToolObstacles::has_friction() const {
  return std::any_of(friction.begin(), friction.end(), [](const CoulombFriction& one) { return one.friction_static > 0.0; });
}

bool ToolObstacles::has_damping() const {
  return std::any_of(damping.begin(), damping.end(), [](const DampingCoefficients& one) { return one.is_on(); });
}

namespace {

// The number of the part that an object moves with, from 1; 0: it stands still. Adds the part if it is new.
int find_part(const TouchObject& object, int number, std::vector<ToolPart>& parts) {
  if (object.command_pivot) {
    parts.push_back({.commanded = number});
    return static_cast<int>(parts.size());
  }
  if (object.motion == nullptr) return 0;
  const auto same = std::find_if(parts.begin(), parts.end(),
                                 [&](const ToolPart& part) { return part.motion != nullptr && *part.motion == *object.motion; });
  const auto index = static_cast<int>(same - parts.begin());
  if (same == parts.end()) parts.push_back({.motion = object.motion});
  return index + 1;
}

}  // namespace

bool has_effects_beyond_tool(const TouchObject& object) {
  SurfaceEffects rest = object.effects;
  rest.viscosity = {};
  return rest.any() || !object.material.two_sided;
}

ToolObstacles make_tool_obstacles(const TouchScene& scene, std::optional<std::size_t> held) {
  ToolObstacles obstacles;
  obstacles.stiffness_n_per_m = find_stiffest_surface(scene);
  obstacles.effects = scene.effects;
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    if (o == held) continue;
    const TouchObject& object = scene.objects[o];
    obstacles.meshes.push_back(object.mesh);
    obstacles.part_of.push_back(find_part(object, static_cast<int>(o), obstacles.parts));
    obstacles.friction.push_back({object.material.friction_static, object.material.friction_dynamic});
    obstacles.damping.push_back({object.material.damping_ns_per_m, object.effects.viscosity.damping_ns_per_m});
    obstacles.leaves_out = obstacles.leaves_out || has_effects_beyond_tool(object);
  }
  return obstacles;
}

}  // namespace hapton
