#include "scene/tool_obstacles.h"

#include <algorithm>

#include "core/force/stiffest.h"

namespace hapton {

bool ToolObstacles::has_friction() const {
  return std::any_of(friction.begin(), friction.end(), [](const SurfaceFriction& one) { return one.friction_static > 0.0; });
}

ToolObstacles make_tool_obstacles(const TouchScene& scene, std::optional<std::size_t> held) {
  ToolObstacles obstacles;
  obstacles.stiffness_n_per_m = find_stiffest(scene);
  obstacles.leaves_out = scene.has_effects();
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    if (o == held) continue;
    const TouchObject& object = scene.objects[o];
    obstacles.meshes.push_back(object.mesh);
    obstacles.friction.push_back({object.material.friction_static, object.material.friction_dynamic});
    obstacles.leaves_out = obstacles.leaves_out || object.material.damping_ns_per_m > 0.0;
  }
  return obstacles;
}

}  // namespace hapton
