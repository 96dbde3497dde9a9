#pragma once

#include <filesystem>
#include <vector>

#include "plugin/plugin_choice.h"
#include "scene/scene_file.h"

namespace hapton {

// The plug-ins that a scene file names as effects. A scene comes from anywhere, and a library runs its code with the rights of whoever
// loads it: so none is loaded unless the person says so. Error: one line: there is one and it is not allowed. RT: no.
Result<std::vector<PluginChoice>> choose_scene_plugins(const Scene& scene, const std::filesystem::path& path, bool is_allowed);

// Whether both name the same plug-ins, in the same order: what was loaded at the start is what runs.
bool has_same_plugins(const Scene& before, const Scene& after);

}  // namespace hapton
