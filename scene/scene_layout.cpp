#include "scene/scene_layout.h"

#include <utility>

#include "scene/accepted_findings.h"
#include "scene/file_bytes.h"
#include "scene/probe_tables.h"
#include "scene/workspace_reader.h"

namespace hapton {
namespace {

constexpr std::size_t kMaxBytes = std::size_t{1} << 24;  // the same as in load_scene

// Reads the accepted findings of each object, by the line of its mesh, as in SceneObject::line.
Result<void> read_accepted(const toml::table& scene, SceneLayout& layout) {
  const toml::array* objects = scene["object"].as_array();
  if (objects == nullptr) return {};
  for (const toml::node& node : *objects) {
    const toml::table* object = node.as_table();
    const toml::node* mesh = object == nullptr ? nullptr : object->get("mesh");
    if (mesh == nullptr) continue;
    auto accepted = read_accepted_findings(*object, "[[object]]");
    if (!accepted) return tl::unexpected(accepted.error());
    if (!accepted->empty()) layout.accepted.emplace(mesh->source().begin.line, std::move(*accepted));
  }
  return {};
}

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
  auto probes = read_probes(*table);
  if (!probes) return tl::unexpected(probes.error());
  layout.probes = std::move(*probes);
  if (const auto accepted = read_accepted(*table, layout); !accepted) return tl::unexpected(accepted.error());
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
  const auto text = read_file_bytes(scene_file, kMaxBytes);
  if (!text) return tl::unexpected(text.error());
  auto layout = parse_layout(*text);
  if (!layout) return fail("{}: {}", scene_file.string(), layout.error().what);
  return layout;
}

}  // namespace hapton
