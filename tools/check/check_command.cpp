#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "scene/scene_combination.h"
#include "scene/scene_file.h"
#include "scene/scene_layout.h"
#include "scene/unit.h"
#include "tools/check/scene_check.h"
#include "tools/commands.h"

namespace hapton {
namespace {

constexpr const char* kDefaultDevice = "model-a";  // the default: the model of the simulated device
constexpr int kExitFindings = 1;                   // exit code: findings
constexpr int kExitCannotCheck = 2;                // exit code: the same as for a command line that cannot be read

struct CheckOptions {
  std::string file;
  std::string unit;
  bool no_fit = false;
  LoopFlags loop;
  SceneCheckSettings settings;
  std::optional<double> delay_ms;
  std::optional<double> probe_radius_m;  // none: the radius in the scene file, or else a point
  bool json = false;
};

// Loads the scene as haptics_node does: a plain mesh is fitted to the workspace.
Result<Scene> load(const CheckOptions& options) {
  if (options.file.ends_with(".toml")) {
    if (!options.unit.empty()) return fail("{}: a scene file names its units itself: leave --unit out", options.file);
    if (options.no_fit) return fail("{}: a scene file says itself whether it is fitted: leave --no-fit out", options.file);
    return load_scene(options.file);
  }
  std::optional<Unit> unit;
  if (!options.unit.empty()) {
    const Result<Unit> parsed = parse_unit(options.unit);
    if (!parsed) return tl::unexpected(parsed.error());
    unit = *parsed;
  }
  return load_scene(options.file, {.unit = unit, .fit = options.no_fit ? MeshFit::off : MeshFit::workspace});
}

Result<bool> run(CheckOptions& options) {
  if (options.loop.device.empty() && !options.loop.mass_kg) options.loop.device = kDefaultDevice;
  auto loops = loops_of(options.loop);
  if (!loops) return tl::unexpected(loops.error());
  SceneCheckSettings& settings = options.settings;
  settings.loops = std::move(*loops);
  settings.delay_s = options.delay_ms ? 1e-3 * *options.delay_ms : kStepShare / settings.rate_hz;
  const auto scene = load(options);
  if (!scene) return tl::unexpected(scene.error());
  if (const auto checked = check_combination(options.file, *scene, scene->tool.has_value()); !checked) {
    return tl::unexpected(checked.error());
  }
  std::vector<ProbeSpec> probes;
  if (options.file.ends_with(".toml")) {
    auto layout = read_layout(options.file);
    if (!layout) return tl::unexpected(layout.error());
    settings.accepted = std::move(layout->accepted);
    probes = std::move(layout->probes);
  }
  // As in haptics_node: the first probe of the scene file, unless --probe-radius is given.
  if (!probes.empty()) settings.probe_radius_m = probes.front().radius_m.value_or(0.0);
  if (options.probe_radius_m) settings.probe_radius_m = *options.probe_radius_m;
  auto check = check_scene(options.file, *scene, settings);
  if (!check) return tl::unexpected(check.error());
  if (!probes.empty() && !options.probe_radius_m) {
    check->notes.push_back(fmt::format("checked for {}; --probe-radius checks for another one", describe(probes.front())));
  }
  std::fputs((options.json ? to_json(*check, settings) : to_text(*check, settings)).c_str(), stdout);
  return check->findings.empty();
}

}  // namespace

void add_check_command(CommandLine app, int& exit_code) {
  auto options = std::make_shared<CheckOptions>();
  options->loop.hand = "light,stylus,arm,firm";
  const CommandLine check = app.add_subcommand("check", "Find what is wrong with a scene before anyone touches it");
  check.add_option("file", options->file, "Scene (.toml) or mesh (.obj, .stl, .ply, .gltf, .glb)").required();
  check.add_option("--unit", options->unit, "Unit of a mesh file: m (default), cm, mm or in; glTF is always m").one_of_names(kUnitNames);
  check.add_flag("--no-fit", options->no_fit, "Keep a mesh file's position and size; default: centred and scaled to the workspace");
  add_loop_flags(check, options->loop, true);
  SceneCheckSettings& settings = options->settings;
  check
      .add_option("--probe-radius", options->probe_radius_m,
                  "Radius of the probe, metres; 0: a point (that of the scene's first [[probe]], or a point)")
      .not_negative("metres");
  check.add_option("--rate", settings.rate_hz, "Servo rate, Hz").between(10.0, 1e6).shows_default();
  check.add_option("--delay", options->delay_ms, "From the sample to its force on the motors, ms (half a cycle)").between(0.0, 10'000.0);
  check.add_flag("--json", options->json, "Print JSON");
  check.on_run([options, &exit_code] {
    const Result<bool> is_clean = run(*options);
    if (!is_clean) std::fprintf(stderr, "hapton check: %s\n", is_clean.error().what.c_str());
    exit_code = !is_clean ? kExitCannotCheck : *is_clean ? 0 : kExitFindings;
  });
}

}  // namespace hapton
