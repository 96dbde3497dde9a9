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

// What is odd about a tool, usually because of a wrong unit or origin, and what to do about it: half a line each.
struct ToolFlaw {
  std::string what;
  std::string fix;
};

// Flaws of its size beside that of the scene, and of where it is held. tool: from the grip point, metres. RT: set-up only.
std::vector<ToolFlaw> find_tool_flaws(const TriangleMesh& tool, const Scene& scene);

}  // namespace hapton
