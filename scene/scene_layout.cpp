#include "scene/scene_layout.h"

#include <utility>

#include "scene/file_bytes.h"
#include "scene/workspace_reader.h"

namespace hapton {
namespace {

constexpr std::size_t kMostBytes = std::size_t{1} << 24;  // as load_scene

Result<SceneLayout> parse_layout(const std::string& text) {
  const auto table = parse_toml(text);
  if (!table) return tl::unexpected(table.error());
  SceneLayout layout;
  const auto workspace = read_workspace(*table);
  if (!workspace) return tl::unexpected(workspace.error());
  layout.workspace = *workspace;
  auto groups = read_groups(*table);
  if (!groups) return tl::unexpected(groups.error());
  layout.groups = std::move(*groups);
  auto instances = read_instances(*table);
  if (!instances) return tl::unexpected(instances.error());
  layout.instances = std::move(*instances);
  if (!table->contains("fit_m")) return layout;
  TableReader reader(*table, "the scene");
  std::array<double, 3> fit = {};
  reader.read("fit_m", fit, 0.0, kMaxLengthM);
  if (reader.error()) return tl::unexpected(*reader.error());
  layout.fit_m = Vec3(fit.data());
  return layout;
}

}  // namespace

Result<SceneLayout> read_layout(const std::filesystem::path& scene_file) {
  const auto text = read_file_bytes(scene_file, kMostBytes);
  if (!text) return tl::unexpected(text.error());
  auto layout = parse_layout(*text);
  if (!layout) return fail("{}: {}", scene_file.string(), layout.error().what);
  return layout;
}

}  // namespace hapton
