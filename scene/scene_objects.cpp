#include "scene/scene_objects.h"

#include <algorithm>

#include "scene/group_expansion.h"
#include "scene/group_reader.h"

namespace hapton {
namespace {

Result<std::vector<ObjectSpec>> read_objects(const toml::table& scene) {
  const toml::array* tables = scene["object"].as_array();
  const toml::node* given = scene.get("object");
  const bool is_empty = tables != nullptr && tables->empty();
  if (given != nullptr && !is_empty && (tables == nullptr || !tables->is_array_of_tables())) {
    return fail("line {}: 'object' must be tables that begin with [[object]]", given->source().begin.line);
  }
  if (tables == nullptr || is_empty) return fail("there is no [[object]]: add one with its mesh");
  std::vector<ObjectSpec> objects;
  for (const toml::node& node : *tables) {
    auto object = read_object(*node.as_table(), fmt::format("[[object]] {}", objects.size() + 1));
    if (!object) return tl::unexpected(object.error());
    objects.push_back(std::move(*object));
  }
  return objects;
}

template <class Spec>
Result<void> check_materials(const std::vector<Spec>& specs, std::span<const std::string_view> known) {
  for (const Spec& spec : specs) {
    if (spec.material.empty() || std::find(known.begin(), known.end(), spec.material) != known.end()) continue;
    return fail("line {}: there is no [material.{}]{}", spec.material_line, printable(spec.material),
                known.empty() ? ": add it" : similar_word_hint(spec.material, known));
  }
  return {};
}

}  // namespace

Result<std::vector<ObjectSpec>> read_scene_objects(const toml::table& scene, std::span<const std::string_view> materials) {
  const auto objects = read_objects(scene);
  if (!objects) return tl::unexpected(objects.error());
  const auto groups = read_groups(scene);
  if (!groups) return tl::unexpected(groups.error());
  const auto instances = read_instances(scene);
  if (!instances) return tl::unexpected(instances.error());
  if (const auto known = check_materials(*objects, materials); !known) return tl::unexpected(known.error());
  for (const auto* specs : {&*groups, &*instances}) {
    if (const auto known = check_materials(*specs, materials); !known) return tl::unexpected(known.error());
  }
  return expand_groups(*objects, *groups, *instances);
}

}  // namespace hapton
