#include <fmt/core.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "runtime/trajectory_csv.h"
#include "scene/scene_file.h"
#include "tools/commands.h"
#include "tools/method_flags.h"
#include "tools/session/replay.h"

namespace hapton {
namespace {

struct ReplayOptions {
  std::string mesh;
  std::string scene;
  std::string unit;
  bool no_seal = false;
  std::string trajectory;
  std::string out;
  MethodFlags method;
  std::optional<double> stiffness_n_per_m;
  std::optional<double> friction_static;
  std::optional<double> friction_dynamic;
  ReplaySettings replay;
};

Result<Scene> load(const ReplayOptions& options) {
  const CrackSealing sealing = options.no_seal ? CrackSealing::off : CrackSealing::on;
  if (!options.scene.empty()) {
    if (!options.unit.empty()) {
      return fail("--unit goes with --mesh; a scene file names the units of its meshes itself");
    }
    return load_scene(options.scene, {.sealing = sealing});
  }
  std::optional<Unit> unit;
  if (!options.unit.empty()) {
    const auto parsed = parse_unit(options.unit);
    if (!parsed) {
      return tl::unexpected(parsed.error());
    }
    unit = *parsed;
  }
  return load_scene(options.mesh, {.unit = unit, .sealing = sealing});
}

// The material of the command line applies to every object of the scene.
Result<TouchScene> make_scene(const ReplayOptions& options, const Scene& scene) {
  TouchScene touch = scene.touch_scene();
  for (TouchObject& object : touch.objects) {
    Material& material = object.material;
    material.stiffness_n_per_m = options.stiffness_n_per_m.value_or(material.stiffness_n_per_m);
    material.friction_static = options.friction_static.value_or(material.friction_static);
    material.friction_dynamic = options.friction_dynamic.value_or(material.friction_dynamic);
    if (material.friction_dynamic > material.friction_static) {
      return fail("dynamic friction {} is above static friction {}; give --friction-static at least as much", material.friction_dynamic,
                  material.friction_static);
    }
  }
  return touch;
}

Result<void> replay(ReplayOptions& options) {
  const auto settings = settings_of(options.method);
  if (!settings) {
    return tl::unexpected(settings.error());
  }
  const auto trajectory = read_trajectory_csv(options.trajectory);
  if (!trajectory) {
    return tl::unexpected(trajectory.error());
  }
  const auto scene = load(options);
  if (!scene) {
    return tl::unexpected(scene.error());
  }
  const auto touch_scene = make_scene(options, *scene);
  if (!touch_scene) {
    return tl::unexpected(touch_scene.error());
  }
  auto method = make_method(*settings, *touch_scene);
  if (!method) {
    return tl::unexpected(method.error());
  }
  for (const std::string& note : scene->notes) {
    fmt::print("{}\n", note);
  }
  TouchStep touch(std::move(*method), *touch_scene);
  SteadyClock clock;
  const Replay done = run_replay(touch, *trajectory, options.replay, clock);
  fmt::print("{}", touch.method().describe());
  fmt::print("{}", describe_replay(done, options.replay));
  return write_replay_csv(options.out, done.rows);
}

int run(ReplayOptions& options) {
  const auto done = replay(options);
  if (!done) {
    fmt::print(stderr, "hapton replay: {}\n", done.error().what);
    return 1;
  }
  return 0;
}

}  // namespace

void add_replay_command(CommandLine app, int& exit_code) {
  auto options = std::make_shared<ReplayOptions>();
  const CommandLine command = app.add_subcommand("replay", "Run the haptic step along a trajectory and write the forces");
  const CommandLine source = command.add_group("what is touched").require_options(1, 1);
  source.add_option("--mesh", options->mesh, "OBJ, STL, PLY, glTF or GLB file");
  source.add_option("--scene", options->scene, "Scene file (TOML)");
  command.add_option("--unit", options->unit, "Unit of the mesh file: m (default), cm, mm or in");
  command.add_flag("--no-seal", options->no_seal, "Do not seal cracks: by default those up to 1e-4 of the longest side are closed");
  command.add_option("--trajectory", options->trajectory, "CSV: t_s,x_m,y_m,z_m[,qw,qx,qy,qz][,sample], one row a step").required();
  command.add_option("--out", options->out, "CSV to write").file_to_write().required();
  add_method_flags(command, options->method);
  command.add_option("--stiffness", options->stiffness_n_per_m, "N/m (default: 1000, or as the scene says)").positive();
  command.add_option("--friction-static", options->friction_static, "Coulomb coefficient (default: 0, or as the scene says)")
      .not_negative();
  command.add_option("--friction-dynamic", options->friction_dynamic, "Coulomb coefficient, not above the static one").not_negative();
  command.add_option("--reset-every", options->replay.reset_every, "Forget all contact before rows 0, N, 2N ...; 0: before row 0 only")
      .shows_default();
  command.add_option("--repeat", options->replay.repeat, "Run it so many times; step_ns is the least of all")
      .between(1, 1'000'000)
      .shows_default();
  command.on_run([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace hapton
