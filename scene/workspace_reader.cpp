#include "scene/workspace_reader.h"

#include "scene/rotation_reader.h"

namespace hapton {

Result<std::optional<Similarity>> read_workspace(const toml::table& scene) {
  const toml::node* node = scene.get("workspace");
  if (node == nullptr) return std::optional<Similarity>();
  if (!node->is_table()) return fail("{}'workspace' must be one table [workspace]", line_prefix(*node));
  const toml::table& table = *node->as_table();
  Similarity workspace;
  TableReader reader(table, "[workspace]");
  reader.allow({"center_m", "rotation_deg", "rotation", "scale"});
  reader.read("center_m", workspace.p, kMaxLengthM);
  reader.read("scale", workspace.scale, 1.0 / kMaxScale, kMaxScale);
  if (!reader.error()) read_rotation(table, reader, workspace.q);
  if (!reader.error() && scene.contains("fit_m")) {
    return fail("{}there are 'fit_m' and [workspace], and both say how large the scene is: keep one", line_prefix(table));
  }
  if (reader.error()) return tl::unexpected(*reader.error());
  return std::optional(workspace);
}

}  // namespace hapton
