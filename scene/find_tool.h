#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scene/scene_file.h"

namespace hapton {

// A tool that a command line names.
struct ToolChoice {
  std::filesystem::path file;     // empty: the tool of the scene, if it has one
  std::optional<Unit> unit = {};  // unit of the file; none: SceneLoading::unit, or m if that is not set either
  ToolGrip grip = ToolGrip::origin;
};

// The chosen tool, else the scene's; nothing if there is neither. A chosen tool is scaled as the scene is: if the scene was fitted to the
// workspace, so is the tool. notes: warnings, one line each. Error: whatever load_mesh_file rejects. RT: set-up only.
Result<std::optional<SceneTool>> find_tool(const ToolChoice& choice, const Scene& scene, const SceneLoading& loading,
                                           std::vector<std::string>& notes);

// What is odd about a tool, usually because of a wrong unit or origin, and what to do about it: half a line each.
struct ToolFlaw {
  std::string what;
  std::string fix;
};

// Finds flaws in the tool's size compared with the scene's, and in where it is held. tool: from the grip point, metres. RT: set-up only.
std::vector<ToolFlaw> find_tool_flaws(const TriangleMesh& tool, const Scene& scene);

}  // namespace hapton
