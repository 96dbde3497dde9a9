#include "tools/check/tool_check.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/tool/tool_step.h"
#include "scene/tool_obstacles.h"

namespace hapton {
namespace {

// As when it is picked up there (Grasp): it gives no force as long as it overlaps.
bool is_blocked(const TouchScene& scene, std::size_t held) {
  ToolObstacles others = make_tool_obstacles(scene, held);
  if (others.meshes.empty()) return false;
  const auto step = ToolStep::make(*scene.objects[held].mesh, std::move(others.meshes), {});
  if (!step) return false;
  (*step)->reset({});
  return (*step)->step({}).proxy.is_blocked;
}

}  // namespace

CheckFindings check_tool(const Scene& scene) {
  CheckFindings findings;
  const TouchScene touched = scene.touch_scene();
  const bool has_movable = std::any_of(scene.objects.begin(), scene.objects.end(), [](const SceneObject& o) { return o.is_movable; });
  if (!scene.tool && !has_movable) return findings;
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    const SceneObject& object = scene.objects[o];
    if (has_effects_no_tool_feels(touched.objects[o])) {
      findings.push_back({SceneFault::shape_alone, object.name, std::nullopt,
                          "a rigid tool feels only its shape, stiffness, friction, damping and viscosity, from both sides",
                          "leave out its other effects, images and two_sided = false, or touch it with a probe"});
    }
    if (object.is_movable && is_blocked(touched, o)) {
      findings.push_back({SceneFault::overlaps, object.name, std::nullopt,
                          "it overlaps or touches another object, so it gives no force after it is picked up until it is clear",
                          "move it away by a little, or leave movable out"});
    }
  }
  return findings;
}

}  // namespace hapton
