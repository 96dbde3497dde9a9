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

// The options of haptics_node's command line, read and checked.
struct HapticsOptions {
  std::string hub = "127.0.0.1";
  std::string bind;      // empty: any address of the hub's family, any port
  std::string key_file;  // empty: the user's shared key, for a hub on loopback only
  std::filesystem::path scene = "scenes/car_front.toml";
  SceneLoading loading = {.fit = MeshFit::workspace};
  bool watch_scene = false;  // read the scene file again when it changes
  std::string probe;         // name of one of the scene file's [[probe]] tables; empty: the first one
  MethodSettings method;
  bool is_method_given = false;             // on the command line; otherwise the method of the [[probe]] applies, if it has one
  bool is_radius_given = false;             // likewise, its radius
  bool is_shading_given = false;            // likewise, its shading
  std::optional<PluginChoice> method_file;  // library of the method 'plugin'
  std::vector<PluginChoice> effects;        // from shared libraries
  bool allow_plugins = false;               // load the libraries that the scene file names
  double plugin_budget_us = 1e-3 * static_cast<double>(CallBudget::kDefaultNs);  // time for each call into a shared library
  // A rigid tool in place of a probe.
  ToolChoice tool;
  int tool_threads = 1;               // threads that share the search for contacts, in addition to the force's thread
  double tool_nm_per_rad = 0.0;       // rotational stiffness; 0: derived from the tool's size
  double tool_voxel_m = 0.0;          // side of the voxels that compute its force; 0: the proxy computes it
  std::filesystem::path annotations;  // file of vision_node with poses of movable objects and carves at the start; empty: none
  int grasp_button = 1;               // button of the stylus that picks up movable objects, counted from 1
  RealtimeSettings realtime;
  std::int64_t plugin_budget_ns() const { return static_cast<std::int64_t>(1e3 * plugin_budget_us); }
  double spin_us = 200.0;         // the longest time to spin for a device sample
  double patch_mbit_per_s = 1.0;  // largest bandwidth for parts of the scene, which the hub requests
  double seconds = 0.0;           // 0: until stopped

  // The crease angle of the method's smooth normals (ProxyMethod::shading_crease_rad); none: it needs no smooth normals.
  std::optional<double> shading_crease_rad() const;
};

// Returns the options, or the exit code that main has to return. RT: set-up only.
std::variant<HapticsOptions, int> parse_haptics_options(int argc, const char* const* argv);

}  // namespace hapton
