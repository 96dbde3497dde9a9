#include "haptics_node/haptics_options.h"

#include <CLI/CLI.hpp>

#include "core/base/worker_team.h"
#include "core/collision/grid_division.h"
#include "core/force/proxy/proxy_method.h"
#include "link/link_key.h"
#include "plugin/plugin_method.h"
#include "runtime/config.h"
#include "runtime/flag_checks.h"

namespace hapton {
namespace {

constexpr double kMetresPerInch = 0.0254;

// Checks only the form of a plug-in's file name and parameters. An unknown method name is rejected later, once the scene is loaded.
std::string check_method(const std::string& word) {
  if (!names_plugin_file(word)) return {};
  const auto choice = parse_plugin_choice(word);
  return choice ? std::string() : choice.error().what;
}

// Option values as text; set_options parses them after the command line was read.
struct HapticsWords {
  std::string grid = "32";
  std::string realtime = "try";
  std::string unit;
  bool no_seal = false;
  bool no_fit = false;
  std::string simplify = "0";
  std::string tool_unit;
  std::vector<std::string> effects;
  std::string tool_grip = "origin";
  double offset_in = 0.0;
};

// The hub, and the scene that is touched.
void add_scene_options(CLI::App& app, HapticsOptions& options, HapticsWords& words) {
  app.add_option("--hub", options.hub, "Where io_node is: HOST or HOST:PORT")->capture_default_str();
  app.add_option("--bind", options.bind, "Local address: ADDRESS:PORT (default: any)");
  app.add_option("--key", options.key_file, kKeyHelp);
  app.add_option("--scene", options.scene, "Scene file (TOML) or mesh file")->capture_default_str();
  app.add_flag("--watch-scene", options.watch_scene,
               "Read the scene file again when it is saved: materials, effects and objects fade in; an error leaves the scene as it is");
  app.add_option("--probe", options.probe,
                 "Probe of the scene file that this node computes, by the name of its [[probe]]: radius, method and shading (default: the "
                 "first one); flags take precedence");
  app.add_option("--unit", words.unit, "Unit of a mesh file: m (default), cm, mm or in")->check(accepts(parse_unit));
  app.add_flag("--no-seal", words.no_seal, "Do not seal cracks: by default those up to 1e-4 of the longest side are closed");
  app.add_flag("--no-fit", words.no_fit, "Keep a mesh file's position and size; default: centred and scaled to the workspace");
}

// The method, and what shared libraries add.
void add_plugin_options(CLI::App& app, HapticsOptions& options, HapticsWords& words) {
  app.add_option("--method", options.method.name,
                 "Force method, one of: " + method_names() + "; or a shared library with one, FILE.so:KEY=VALUE,... (docs/plugins.md)")
      ->check(CLI::Validator(check_method, ""))
      ->capture_default_str();
  app.add_option("--effect", words.effects,
                 "Effect from a shared library, added to the force: FILE.so or FILE.so:KEY=VALUE,... (docs/plugins.md); may be repeated")
      ->check(accepts(parse_plugin_choice));
  app.add_flag("--allow-plugins", options.allow_plugins,
               "Load the shared libraries that the scene file names as effects, which runs their code; default: such a scene is rejected");
  app.add_option("--plugin-budget", options.plugin_budget_us,
                 "Time for each call of a plug-in, us; one that overruns it too often is cut off")
      ->check(between(1.0, 1e4))
      ->capture_default_str();
}

// Settings of single methods.
void add_method_options(CLI::App& app, HapticsOptions& options, HapticsWords& words) {
  app.add_option("--grid", words.grid, "sweep: cells along each axis, N or NxNxN")
      ->check(accepts(parse_grid_division))
      ->capture_default_str();
  app.add_option("--offset-in", words.offset_in, "sweep: length of the offset vector, inches")
      ->check(above_zero("inches"))
      ->capture_default_str();
  app.add_option("--set-size", options.method.set_size, "smooth: triangles in the local set, 16 to 256")->capture_default_str();
  app.add_option("--radius", options.method.smooth_radius_m,
                 "smooth: RADIUS, the distance within which a triangle exerts force, metres; 0: derived from the mesh")
      ->capture_default_str();
  app.add_option("--layer", options.method.smooth_layer,
                 "smooth: share of RADIUS over which force builds up outside the surface, 0 to 1; 1: Algorithm 1 of the FDH paper")
      ->capture_default_str();
  app.add_option("--directions", options.method.hull_directions, "smooth: directions of its bounding hulls: 6, 14, 18 or 26")
      ->capture_default_str();
  app.add_option("--crease", options.method.crease_deg,
                 "smooth, proxy with shading: edges at which the surface turns by more degrees than this are sharp")
      ->check(between(0.0, 180.0))
      ->capture_default_str();
  app.add_option("--simplify", words.simplify,
                 "smooth: simplify the mesh within this distance of its surface, such as 0.1mm; 0: do not simplify")
      ->check(accepts(parse_length))
      ->capture_default_str();
}

void add_probe_options(CLI::App& app, HapticsOptions& options) {
  app.add_option("--probe-radius", options.method.probe_radius_m,
                 "Radius of the probe, metres; 0: a point (sweep and smooth have only points)")
      ->check(zero_or_more("metres"))
      ->capture_default_str();
  app.add_option("--coupling", options.method.coupling_n_per_m,
                 "Virtual coupling, N/m: a spring between device and probe, so that no material is stiffer (effects may be); 0: none "
                 "(hapton loop recommend)")
      ->check(between(0.0, 1e6))
      ->capture_default_str();
  app.add_option("--shading", options.method.shading, "proxy: force direction from face normals (0) to smooth normals (1)")
      ->check(between(0.0, 1.0))
      ->capture_default_str();
  app.add_flag("--build-on-approach,!--build-at-once", options.method.build_on_approach,
               "proxy: build an object's structures when the probe first approaches it, while the loop runs")
      ->default_str("true");
}

// Options of a rigid tool, also of an object that is picked up.
void add_tool_options(CLI::App& app, HapticsOptions& options, HapticsWords& words) {
  const auto tool =
      app.add_option("--tool", options.tool.file,
                     "Mesh of a rigid tool that the stylus holds in place of a probe: force and torque (docs/tool.md; default: "
                     "the scene's [tool], if it has one)");
  app.add_option("--tool-unit", words.tool_unit, "Unit of the tool's file: m, cm, mm or in (default: --unit)")
      ->check(accepts(parse_unit))
      ->needs(tool);
  app.add_option("--tool-grip", words.tool_grip, "Where the stylus holds it: origin (of its mesh) or centre (of its box)")
      ->check(accepts(parse_tool_grip))
      ->capture_default_str()
      ->needs(tool);
  app.add_option("--rotational-stiffness", options.tool_nm_per_rad, "Rotational stiffness of the tool, Nm/rad; 0: derived from its size")
      ->check(between(0.0, 1e6))
      ->capture_default_str();
  app.add_option("--tool-threads", options.tool_threads,
                 "Threads that share a tool's search for contacts, in addition to the force's thread; the pose is the same with any number")
      ->check(between(1, WorkerTeam::kMaxWorkers))
      ->capture_default_str();
  app.add_option("--tool-voxels", options.tool_voxel_m,
                 "Compute the rigid tool's force with voxels of that side, m, and a shell of points instead (McNeely et al. 1999), for "
                 "comparison; 0: off")
      ->check(between(0.0, 1.0))
      ->capture_default_str();
  app.add_option("--grasp-button", options.grasp_button,
                 "Button of the stylus that picks up an object that the scene marks movable, and puts it down when released (docs/tool.md)")
      ->check(between(1, 32))
      ->capture_default_str();
  app.add_option(
      "--annotations", options.annotations,
      "File of vision_node --annotations: poses of movable objects, and what was carved, at the start (docs/tool.md, docs/vision.md)");
}

void add_loop_options(CLI::App& app, HapticsOptions& options, HapticsWords& words) {
  app.add_option("--rt", words.realtime, "Real-time priority, memory lock and wake-up latency: off, try or require")
      ->check(accepts(parse_realtime_mode))
      ->capture_default_str();
  app.add_option("--rt-priority", options.realtime.priority, "SCHED_FIFO priority; 0: ordinary thread")
      ->check(between(0, 99))
      ->capture_default_str();
  app.add_option("--cpu", options.realtime.cpu, "Pin to this CPU; -1: any")->check(between(-1, 1023))->capture_default_str();
  app.add_option("--spin", options.spin_us,
                 "Longest time to spin for each device sample before the loop sleeps, us, where that saves time (docs/realtime.md); 0: it "
                 "sleeps until a sample arrives")
      ->check(between(0.0, 1000.0))
      ->capture_default_str();
  app.add_option("--patch-bandwidth", options.patch_mbit_per_s,
                 "Largest bandwidth for parts of the scene, Mbit/s; the hub requests them if the network is slow (docs/remote.md)")
      ->check(between(0.01, 1000.0))
      ->capture_default_str();
  app.add_option("--seconds", options.seconds, "End after this long, s; 0: when stopped (Ctrl-C)")
      ->check(between(0.0, 1e9))
      ->capture_default_str();
}

void set_options(const CLI::App& app, const HapticsWords& words, HapticsOptions& options) {
  options.is_method_given = app.count("--method") > 0;
  options.is_radius_given = app.count("--probe-radius") > 0;
  options.is_shading_given = app.count("--shading") > 0;
  options.method.grid_division = *parse_grid_division(words.grid);
  if (names_plugin_file(options.method.name)) {
    options.method_file = *parse_plugin_choice(options.method.name);
    options.method.name = kPluginMethod;
  }
  for (const std::string& effect : words.effects) options.effects.push_back(*parse_plugin_choice(effect));
  options.method.simplify_m = *parse_length(words.simplify);
  options.method.offset_m = words.offset_in * kMetresPerInch;
  options.realtime.mode = *parse_realtime_mode(words.realtime);
  if (!words.unit.empty()) options.loading.unit = *parse_unit(words.unit);
  if (!words.tool_unit.empty()) options.tool.unit = *parse_unit(words.tool_unit);
  options.tool.grip = *parse_tool_grip(words.tool_grip);
  if (words.no_seal) options.loading.sealing = CrackSealing::off;
  if (words.no_fit) options.loading.fit = MeshFit::off;
}

}  // namespace

std::variant<HapticsOptions, int> parse_haptics_options(int argc, const char* const* argv) {
  HapticsOptions options;
  HapticsWords words;
  options.method.build_on_approach = true;
  words.offset_in = options.method.offset_m / kMetresPerInch;

  CLI::App app{"Computes the force for every device sample of the hub.", "haptics_node"};
  add_scene_options(app, options, words);
  add_plugin_options(app, options, words);
  add_method_options(app, options, words);
  add_probe_options(app, options);
  add_tool_options(app, options, words);
  add_loop_options(app, options, words);

  if (const auto code = parse_command_line(app, argc, argv)) return *code;
  set_options(app, words, options);
  return options;
}

std::optional<double> HapticsOptions::shading_crease_rad() const { return ProxyMethod::shading_crease_rad(method); }

}  // namespace hapton
