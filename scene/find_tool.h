#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scene/scene_file.h"

namespace hapton {

// A tool as a command line names it.
struct ToolChoice {
  std::filesystem::path file;     // empty: the scene's, if it has one
  std::optional<Unit> unit = {};  // of the file; none: as the scene's, which a scene file gives each of its meshes: m
  ToolGrip grip = ToolGrip::origin;
};

// That tool, or the scene's; nothing where neither names one. It is as large as the scene is shown: a mesh that was fitted to the workspace
// takes the tool along. notes: warnings, one line each. Error: whatever load_mesh_file rejects. RT: set-up only.
Result<std::optional<SceneTool>> find_tool(const ToolChoice& choice, const Scene& scene, const SceneLoading& loading,
                                           std::vector<std::string>& notes);

}  // namespace hapton
