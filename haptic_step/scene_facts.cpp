#include "haptic_step/scene_facts.h"

#include <algorithm>

#include "scene/surface_points.h"

namespace hapton {
namespace {

// Clamps to the limit of the message; a point beyond it is out of reach anyway.
SceneFacts::Point to_point(const Vec3& p) {
  constexpr double kFarthestM = 1e8;
  const Eigen::Vector3f near = p.cwiseMax(-kFarthestM).cwiseMin(kFarthestM).cast<float>();
  return {near.x(), near.y(), near.z()};
}

}  // namespace

SceneFacts make_scene_facts(const Scene& scene) {
  SceneFacts facts;
  facts.given_hash = scene.given_hash;
  facts.tool_hash = scene.tool ? scene.tool->given_hash : SceneFacts::kNoTool;
  Eigen::AlignedBox3d box;
  for (const SceneObject& object : scene.objects) {
    for (const Vec3& vertex : object.mesh->vertices) box.extend(vertex);
  }
  if (!box.isEmpty()) {
    facts.lowest_m = to_point(box.min());
    facts.highest_m = to_point(box.max());
  }
  for (const Vec3& p : find_surface_points(scene.touch_scene(), facts.points_m.size())) facts.points_m[facts.point_count++] = to_point(p);
  return facts;
}

}  // namespace hapton
