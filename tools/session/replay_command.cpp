#include <fmt/core.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "core/tool/tool_step.h"
#include "runtime/trajectory_csv.h"
#include "runtime/worker_threads.h"
#include "scene/find_tool.h"
#include "scene/material_limits.h"
#include "scene/scene_file.h"
#include "scene/tool_obstacles.h"
#include "scene/unit.h"
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
  std::string tool;
  std::string tool_unit;
  std::string tool_grip;  // empty: the origin of the tool's mesh
  double rotational_stiffness_nm_per_rad = 0.0;
  double tool_voxel_m = 0.0;  // 0: no voxels
  int tool_threads = 1;
  MethodFlags method;
  std::optional<double> stiffness_n_per_m;
  std::optional<double> friction_static;
  std::optional<double> friction_dynamic;
  ReplaySettings replay;
};

Result<Scene> load_mesh(const std::string& path, const std::string& unit_name, CrackSealing sealing) {
  std::optional<Unit> unit;
  if (!unit_name.empty()) {
    const auto parsed = parse_unit(unit_name);
    if (!parsed) {
      return tl::unexpected(parsed.error());
    }
    unit = *parsed;
  }
  return load_scene(path, {.unit = unit, .sealing = sealing});
}

Result<Scene> load(const ReplayOptions& options) {
  const CrackSealing sealing = options.no_seal ? CrackSealing::off : CrackSealing::on;
  if (options.scene.empty()) {
    return load_mesh(options.mesh, options.unit, sealing);
  }
  if (!options.unit.empty()) {
    return fail("--unit goes with --mesh; a scene file names the units of its meshes itself");
  }
  return load_scene(options.scene, {.sealing = sealing});
}

Result<std::optional<SceneTool>> choose_tool(const ReplayOptions& options, const Scene& scene) {
  ToolChoice choice{.file = options.tool};
  const std::string unit_name = options.tool_unit.empty() ? options.unit : options.tool_unit;
  if (!unit_name.empty()) {
    const auto unit = parse_unit(unit_name);
    if (!unit) {
      return tl::unexpected(unit.error());
    }
    choice.unit = *unit;
  }
  const auto grip = parse_tool_grip(options.tool_grip.empty() ? "origin" : options.tool_grip);
  if (!grip) {
    return tl::unexpected(grip.error());
  }
  choice.grip = *grip;
  std::vector<std::string> notes;
  auto tool = find_tool(choice, scene, {.sealing = options.no_seal ? CrackSealing::off : CrackSealing::on}, notes);
  for (const std::string& note : notes) {
    fmt::print("tool: {}\n", note);
  }
  if (tool && *tool) {
    for (const ToolFlaw& flaw : find_tool_flaws(*(*tool)->mesh, scene)) fmt::print("warning: {}; {}\n", flaw.what, flaw.fix);
  }
  return tool;
}

// Rejects flags that do not go together. A flag that a tool does not support yet, but a point or sphere does, is an error, not ignored.
Result<void> check_tool_options(const ReplayOptions& options, bool has_tool) {
  const MethodSettings& method = options.method.settings;
  const MethodSettings default_settings;
  if (options.tool.empty()) {
    const std::string_view reason = has_tool ? "; the scene file gives that of its [tool]" : "";
    if (!options.tool_unit.empty()) return fail("--tool-unit goes with --tool FILE{}", reason);
    if (!options.tool_grip.empty()) return fail("--tool-grip goes with --tool FILE{}", reason);
  }
  if (!has_tool) {
    if (options.rotational_stiffness_nm_per_rad > 0.0) return fail("--rotational-stiffness goes with --tool");
    if (options.tool_voxel_m > 0.0) return fail("--tool-voxels goes with --tool");
    if (options.tool_threads > 1) return fail("--tool-threads goes with --tool");
    return {};
  }
  if (options.tool_threads > 1 && options.tool_voxel_m > 0.0) return fail("--tool-threads does not go with --tool-voxels");
  if (method.name != default_settings.name) return fail("--tool goes with --method proxy; '{}' has no tool", method.name);
  if (method.probe_radius_m > 0.0) return fail("--tool and --probe-radius are two probes; give one");
  if (method.shading > 0.0 || method.coupling_n_per_m > 0.0) return fail("--shading and --coupling do not go with --tool");
  return {};
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

Result<Replay> replay_probe(const ReplayOptions& options, const MethodSettings& settings, const Scene& scene,
                            std::span<const TrajectoryRow> trajectory) {
  const auto touch_scene = make_scene(options, scene);
  if (!touch_scene) {
    return tl::unexpected(touch_scene.error());
  }
  if (touch_scene->has_streamed()) {
    fmt::print("objects of {} that programs deform are at rest: a trajectory has no shapes\n", options.scene);
  }
  if (touch_scene->has_sculpt() && options.replay.repeat > 1) {
    return fail("objects of {} can be carved, so a repetition would begin with another shape: leave out --repeat", options.scene);
  }
  auto method = make_method(settings, *touch_scene);
  if (!method) {
    return tl::unexpected(method.error());
  }
  TouchStep touch(std::move(*method), *touch_scene);
  Replay done = run_replay(touch, trajectory, options.replay, SteadyClock());
  fmt::print("{}", touch.method().describe());
  return done;
}

Result<Replay> replay_tool(const ReplayOptions& options, const Scene& scene, const SceneTool& scene_tool,
                           std::span<const TrajectoryRow> trajectory) {
  const auto touch_scene = make_scene(options, scene);
  if (!touch_scene) return tl::unexpected(touch_scene.error());
  if (touch_scene->has_sculpt()) return fail("objects of {} can be carved, which a rigid tool does not support", options.scene);
  if (touch_scene->has_deformation()) {
    return fail("objects of {} deform, which a rigid tool does not support: leave out the tool", options.scene);
  }
  if (touch_scene->has_motion() && options.tool_voxel_m > 0.0) {
    return fail("objects of {} move, which --tool-voxels does not support: leave it out", options.scene);
  }
  const ToolObstacles obstacles = make_tool_obstacles(*touch_scene);
  const ToolCoupling coupling{.stiffness_n_per_m = obstacles.stiffness_n_per_m,
                              .rotational_stiffness_nm_per_rad = options.rotational_stiffness_nm_per_rad};
  if (obstacles.leaves_out) {
    fmt::print("tool: effects of surfaces but viscosity_ns_per_m, images, and two_sided = false of {} are left out: {:g} N/m everywhere\n",
               options.scene, coupling.stiffness_n_per_m);
  }
  const auto run_tool = [&](const auto& tool, const auto&... parts) -> Result<Replay> {
    if (!tool) return tl::unexpected(tool.error());
    Replay done = run_replay(**tool, trajectory, options.replay, SteadyClock(), parts...);
    add_space_effects(obstacles.effects, trajectory, options.replay, done);
    fmt::print("{}", (*tool)->describe());
    return done;
  };
  if (options.tool_voxel_m <= 0.0) {
    auto tool = ToolStep::make(*scene_tool.mesh, obstacles.meshes, coupling, obstacles.friction, make_worker_team(options.tool_threads),
                               obstacles.part_of);
    if (!tool) return tl::unexpected(tool.error());
    if (const auto damped = (*tool)->damp(obstacles.damping); !damped) return tl::unexpected(damped.error());
    return run_tool(tool, obstacles.parts);
  }
  if (obstacles.has_friction()) fmt::print("tool: voxels have no friction, so the scene's is left out\n");
  if (obstacles.has_damping()) fmt::print("tool: voxels have no damping and viscosity, so the scene's are left out\n");
  return run_tool(VoxelTool::make(*scene_tool.mesh, obstacles.meshes, coupling, options.tool_voxel_m));
}

void note_buttons(const Scene& scene, std::span<const TrajectoryRow> trajectory) {
  const bool can_pick_up = std::any_of(scene.objects.begin(), scene.objects.end(), [](const auto& object) { return object.is_movable; });
  const bool has_presses = std::any_of(trajectory.begin(), trajectory.end(), [](const TrajectoryRow& row) { return row.buttons != 0; });
  if (!can_pick_up || !has_presses) return;
  fmt::print("movable objects stay where they are: a replay picks nothing up. deploy/run --device simulated --trajectory FILE does\n");
}

// Checked before a run that may take minutes, because write_replay_csv does not make the folder.
Result<void> check_folder_of(const std::filesystem::path& out) {
  const std::filesystem::path folder = out.parent_path();
  std::error_code error;
  if (folder.empty() || std::filesystem::is_directory(folder, error)) return {};
  return fail("{}: cannot be written: there is no folder {}; make it, or give another place", out.string(), folder.string());
}

Result<void> replay(ReplayOptions& options) {
  if (const auto checked = check_folder_of(options.out); !checked) return checked;
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
  for (const std::string& note : scene->notes) {
    fmt::print("{}\n", note);
  }
  note_buttons(*scene, *trajectory);
  const auto tool = choose_tool(options, *scene);
  if (!tool) {
    return tl::unexpected(tool.error());
  }
  if (const auto checked = check_tool_options(options, tool->has_value()); !checked) {
    return checked;
  }
  const auto done = *tool ? replay_tool(options, *scene, **tool, *trajectory) : replay_probe(options, *settings, *scene, *trajectory);
  if (!done) {
    return tl::unexpected(done.error());
  }
  fmt::print("{}", describe_replay(*done, options.replay));
  return write_replay_csv(options.out, *done);
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
  command.add_option("--unit", options->unit, "Unit of the mesh file: m (default), cm, mm or in").one_of_names(kUnitNames);
  command.add_flag("--no-seal", options->no_seal, "Do not seal cracks: by default those up to 1e-4 of the longest side are closed");
  command.add_option("--trajectory", options->trajectory, "CSV: t_s,x_m,y_m,z_m[,qw,qx,qy,qz][,buttons][,sample], one row a step")
      .required();
  command.add_option("--tool", options->tool,
                     "Mesh of a rigid tool instead of a point or a ball: force and torque (default: the scene's [tool], if it has one)");
  command.add_option("--tool-unit", options->tool_unit, "Unit of the tool's mesh (default: as --unit)").one_of_names(kUnitNames);
  command.add_option("--tool-grip", options->tool_grip,
                     "Where the stylus holds it: origin (of its mesh, the default) or centre (of its box)");
  command
      .add_option("--rotational-stiffness", options->rotational_stiffness_nm_per_rad,
                  "With --tool: rotational stiffness, Nm/rad; 0: from --stiffness and the tool's size")
      .between(0.0, 1e6)
      .shows_default();
  command
      .add_option("--tool-voxels", options->tool_voxel_m,
                  "With --tool, m: follow it by voxels of that side and a shell of points instead (McNeely et al. 1999), for comparison")
      .positive("m");
  command
      .add_option("--tool-threads", options->tool_threads,
                  "With --tool: threads that share the search for contacts; the result is the same")
      .between(1, WorkerTeam::kMaxWorkers)
      .shows_default();
  command.add_option("--out", options->out, "CSV to write").file_to_write().required();
  add_method_flags(command, options->method);
  command.add_option("--stiffness", options->stiffness_n_per_m, "Stiffness, N/m (default: 1000, or that of the scene)")
      .positive()
      .between(0.0, kStiffnessLimit.most);
  command.add_option("--friction-static", options->friction_static, "Static friction coefficient (default: 0, or that of the scene)")
      .between(0.0, kFrictionStaticLimit.most);
  command.add_option("--friction-dynamic", options->friction_dynamic, "Dynamic friction coefficient, at most the static one")
      .between(0.0, kFrictionDynamicLimit.most);
  command.add_option("--reset-every", options->replay.reset_every, "Forget all contact before rows 0, N, 2N ...; 0: before row 0 only")
      .shows_default();
  command.add_option("--repeat", options->replay.repeat, "Number of runs; step_ns is the minimum over them")
      .between(1, 1'000'000)
      .shows_default();
  command.on_run([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace hapton
