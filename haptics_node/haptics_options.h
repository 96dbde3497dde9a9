#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/force/force_method.h"
#include "plugin/call_budget.h"
#include "plugin/plugin_choice.h"
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
  std::string probe;         // of the scene file's [[probe]] tables; empty: the first one
  MethodSettings method;
  bool is_method_given = false;             // given on the command line; otherwise the method of the [[probe]] applies, if there is one
  bool is_radius_given = false;             // likewise
  bool is_shading_given = false;            // likewise
  std::optional<PluginChoice> method_file;  // of the method 'plugin'
  std::vector<PluginChoice> effects;        // from shared libraries
  bool allow_plugins = false;               // load the libraries that the scene file names
  double plugin_budget_us = 1e-3 * static_cast<double>(CallBudget::kDefaultNs);  // of each call into a shared library
  // A rigid tool in place of a probe.
  ToolChoice tool;
  int tool_threads = 1;               // that share the search for contacts, besides the force's thread
  double tool_nm_per_rad = 0.0;       // rotational stiffness; 0: derived from its size
  double tool_voxel_m = 0.0;          // voxels of that side compute its force; 0: the proxy does
  std::filesystem::path annotations;  // file of vision_node: poses of movable objects and carves at the start; empty: none
  int grasp_button = 1;               // of the stylus, from 1: picks up movable objects
  RealtimeSettings realtime;
  std::int64_t plugin_budget_ns() const { return static_cast<std::int64_t>(1e3 * plugin_budget_us); }
  double spin_us = 200.0;         // the longest time to spin for a device sample
  double patch_mbit_per_s = 1.0;  // for parts of the scene, when the hub asks for them
  double seconds = 0.0;           // 0: until stopped

  // Of the method's smooth normals, as ProxyMethod has it.
  std::optional<double> shading_crease_rad() const;
};

// The options, or the exit code to leave main with. RT: set-up only.
std::variant<HapticsOptions, int> parse_haptics_options(int argc, const char* const* argv);

}  // namespace hapton
