#include "haptics_node/scene_plugins.h"

#include <algorithm>

#include "scene/text_cursor.h"

namespace hapton {

Result<std::vector<PluginChoice>> choose_scene_plugins(const Scene& scene, const std::filesystem::path& path, bool is_allowed) {
  std::vector<PluginChoice> choices;
  for (const LibraryEffect& named : scene.libraries) {
    if (!is_allowed) {
      return fail("{}: line {}: effect {} would run the code of {}: give --allow-plugins if you trust it, or take it out of the scene",
                  path.string(), named.line, printable(named.name), printable(named.library.string()));
    }
    choices.push_back({.file = named.library.string(), .parameters = named.parameters});
  }
  return choices;
}

bool has_same_plugins(const Scene& before, const Scene& after) {
  return std::equal(before.libraries.begin(), before.libraries.end(), after.libraries.begin(), after.libraries.end(),
                    [](const LibraryEffect& a, const LibraryEffect& b) { return a.same_as(b); });
}

}  // namespace hapton
