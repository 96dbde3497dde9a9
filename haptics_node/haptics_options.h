#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <variant>

#include "core/force/force_method.h"
#include "runtime/realtime.h"
#include "scene/find_tool.h"
#include "scene/scene_loading.h"

namespace hapton {

// The command line, read and checked.
struct HapticsOptions {
  std::string hub = "127.0.0.1";
  std::string bind;      // empty: any address of the hub's family, any port
  std::string key_file;  // empty: the user's own, on loopback
  std::filesystem::path scene = "scenes/car_front.toml";
  SceneLoading loading = {.fit = MeshFit::workspace};
  bool watch_scene = false;  // read the scene file again when it changes
  MethodSettings method;
  // A rigid tool in place of a probe.
  ToolChoice tool;
  double tool_nm_per_rad = 0.0;  // rotational stiffness; 0: derived from its size
  RealtimeSettings realtime;
  double patch_mbit_per_s = 1.0;  // for parts of the scene, when the hub asks for them
  double seconds = 0.0;           // 0: until stopped
};

// The options, or the exit code to leave main with. RT: set-up only.
std::variant<HapticsOptions, int> parse_haptics_options(int argc, const char* const* argv);

}  // namespace hapton
