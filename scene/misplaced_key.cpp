#include "scene/misplaced_key.h"

#include <string_view>

namespace hapton {
namespace {

constexpr std::string_view kKeyOfTheScene = "fit_m";

// Does not search the parameters of a plug-in effect, which may have any names.
const toml::node* find_key_below(const toml::node& node) {
  const toml::node* found = nullptr;
  if (const toml::table* table = node.as_table()) {
    found = table->get(kKeyOfTheScene);
    for (auto it = table->begin(); it != table->end() && found == nullptr; ++it) {
      if (it->first.str() != "parameters") found = find_key_below(it->second);
    }
  } else if (const toml::array* array = node.as_array()) {
    for (auto it = array->begin(); it != array->end() && found == nullptr; ++it) found = find_key_below(*it);
  }
  return found;
}

}  // namespace

Result<void> find_misplaced_key(const toml::table& scene) {
  for (const auto& [name, node] : scene) {
    if (name.str() == kKeyOfTheScene) continue;
    const toml::node* found = find_key_below(node);
    // A table of this name is not misplaced: it is a material that is called fit_m.
    if (found == nullptr || found->is_table()) continue;
    return fail(
        "{}'{}' is a key of the whole scene, and TOML gives it to the table above it: move it above the first line that begins with [",
        line_prefix(*found), kKeyOfTheScene);
  }
  return {};
}

}  // namespace hapton
