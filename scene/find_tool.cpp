#include "scene/find_tool.h"

#include <utility>

#include "scene/scene_hash.h"
#include "scene/touch_mesh.h"

namespace hapton {

Result<std::optional<SceneTool>> find_tool(const ToolChoice& choice, const Scene& scene, const SceneLoading& loading,
                                           std::vector<std::string>& notes) {
  if (choice.file.empty()) return scene.tool;
  Result<TouchMesh> file = load_touch_mesh(choice.file, choice.unit ? choice.unit : loading.unit, loading.sealing, LookReading::off);
  if (!file) return tl::unexpected(file.error());
  for (const std::string& note : file->notes) notes.push_back(fmt::format("{}: {}", choice.file.string(), note));
  return SceneTool{.name = choice.file.stem().string(),
                   .mesh = std::make_shared<const TriangleMesh>(from_grip(std::move(file->mesh), choice.grip, scene.fit_scale)),
                   .given_hash = hash_tool(hash_placed(file->given_hash, 1.0, Quat::Identity(), Vec3::Zero()), choice.grip)};
}

}  // namespace hapton
