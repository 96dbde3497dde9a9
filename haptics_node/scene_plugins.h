#pragma once

#include <filesystem>
#include <vector>

#include "plugin/plugin_choice.h"
#include "scene/scene_file.h"

namespace hapton {

// The plug-ins that a scene file names as effects. A scene file may come from an untrusted source, and a library runs its code with the
// rights of the user who loads it: so they need the user's consent. Error: one line: there is a plug-in, and is_allowed is false. RT: no.
Result<std::vector<PluginChoice>> choose_scene_plugins(const Scene& scene, const std::filesystem::path& path, bool is_allowed);

// Whether both scenes name the same plug-ins in the same order. Plug-ins are loaded at the start only, so they cannot change later.
bool has_same_plugins(const Scene& before, const Scene& after);

}  // namespace hapton
