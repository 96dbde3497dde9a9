#include "scene/find_tool.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <utility>

#include "core/geometry/mesh_measures.h"
#include "scene/scene_hash.h"
#include "scene/touch_mesh.h"

namespace hapton {

Result<std::optional<SceneTool>> find_tool(const ToolChoice& choice, const Scene& scene, const SceneLoading& loading,
                                           std::vector<std::string>& notes) {
  if (choice.file.empty()) return scene.tool;
  Result<TouchMesh> file = load_touch_mesh(choice.file, choice.unit ? choice.unit : loading.unit, loading.sealing, AppearanceReading::off);
  if (!file) return tl::unexpected(file.error());
  for (const std::string& note : file->notes) notes.push_back(fmt::format("{}: {}", choice.file.string(), note));
  return SceneTool{.name = choice.file.stem().string(),
                   .mesh = std::make_shared<const TriangleMesh>(from_grip(std::move(file->mesh), choice.grip, scene.fit_scale)),
                   .given_hash = hash_tool(hash_placed(file->given_hash, 1.0, Quat::Identity(), Vec3::Zero()), choice.grip)};
}

std::vector<ToolFlaw> find_tool_flaws(const TriangleMesh& tool, const Scene& scene) {
  // The limits are wide: a needle or a table can be a tool too, and the grip point of a stylus may be far from its tip.
  constexpr double kSmall = 1e-3;  // kSmall, kLarge and kFarOfScene: shares of the scene's extent
  constexpr double kLarge = 10.0;
  constexpr double kFar = 2.0;  // share of the tool's extent
  constexpr double kFarOfScene = 0.5;
  std::vector<ToolFlaw> flaws;
  Eigen::AlignedBox3d box;
  for (const SceneObject& object : scene.objects) {
    for (const Vec3& p : object.mesh->vertices) box.extend(p);
  }
  const double scene_longest_m = box.isEmpty() ? 0.0 : box.sizes().maxCoeff();
  if (tool.vertices.empty() || !(scene_longest_m > 0.0)) return flaws;
  const MeshBounds bounds = compute_bounds(tool);
  const double longest = bounds.extent();
  if (longest < kSmall * scene_longest_m || longest > kLarge * scene_longest_m) {
    flaws.push_back({fmt::format("the tool is {:.5g} mm long, the scene {:.5g} mm", 1e3 * longest, 1e3 * scene_longest_m),
                     "check the units of both (--tool-unit, or unit in [tool])"});
  }
  const double away = bounds.low.cwiseMax(-bounds.high).cwiseMax(0.0).norm();
  if (away > kFar * longest && away > kFarOfScene * scene_longest_m) {
    flaws.push_back(
        {fmt::format("the tool is {:.5g} mm away from where the stylus holds it, and {:.5g} mm long", 1e3 * away, 1e3 * longest),
         "hold it in the middle (--tool-grip centre, or grip = \"centre\" in [tool]), or move its mesh to the origin"});
  }
  return flaws;
}

}  // namespace hapton
