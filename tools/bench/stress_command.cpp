#include <fmt/core.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "runtime/atomic_file.h"
#include "scene/material_limits.h"
#include "scene/mesh_file.h"
#include "scene/touch_mesh.h"
#include "tools/bench/stress.h"
#include "tools/bench/tool_stress.h"
#include "tools/commands.h"

namespace hapton {
namespace {

struct StressOptions {
  std::vector<std::string> bodies;
  std::vector<std::string> files;
  std::string out;
  std::optional<double> scale, offset, friction_static, friction_dynamic;
  std::optional<std::uint64_t> episode;
  bool tool = false;
  bool moving = false;
  StressPlan plan;
};

std::string body_names() {
  std::string names;
  for (const std::string_view name : stress_body_names()) {
    if (!names.empty()) names += ", ";
    names += name;
  }
  return names;
}

Result<std::vector<StressBody>> make_bodies(const StressOptions& options) {
  const CrackSealing sealing = options.plan.no_seal ? CrackSealing::off : CrackSealing::on;
  std::vector<StressBody> bodies;
  std::vector<std::string> names = options.bodies;
  if (names.empty() && options.files.empty()) {
    // All bodies whose probe the method supports.
    const bool has_spheres = supports_spheres(options.plan.method.name);
    for (const std::string_view name : stress_body_names()) {
      if (has_spheres || !name.starts_with("probe-")) names.emplace_back(name);
    }
  }
  for (const std::string& name : names) {
    StressBody body = make_stress_body(name);
    // A finding may name a mesh file as its body, and its command must be repeatable literally: so --body accepts a mesh file, too.
    if (body.touched.triangles.empty() && is_mesh_file_name(name)) {
      auto file = load_touch_mesh(name, std::nullopt, sealing);
      if (!file) return tl::unexpected(file.error());
      body = make_stress_body(name, std::move(file->mesh));
    }
    bodies.push_back(std::move(body));
  }
  for (const std::string& path : options.files) {
    auto file = load_touch_mesh(path, std::nullopt, sealing);
    if (!file) return tl::unexpected(file.error());
    bodies.push_back(make_stress_body(path, std::move(file->mesh)));
  }
  return bodies;
}

Result<void> choose_variant(StressOptions& options) {
  if (options.plan.by_patches) {
    if (options.plan.method.name != "proxy") return fail("--patches supports only method proxy; leave out --method");
    options.plan.variants = patch_variants();
  }
  if (!options.scale && !options.offset && !options.friction_static && !options.friction_dynamic) return {};
  options.plan.variants = {{.scale = options.scale.value_or(1.0),
                            .offset_extents = options.offset.value_or(0.0),
                            .friction_static = options.friction_static.value_or(0.0),
                            .friction_dynamic = options.friction_dynamic.value_or(0.0)}};
  const StressVariant& variant = options.plan.variants.front();
  if (variant.friction_dynamic > variant.friction_static) {
    return fail("dynamic friction {} is above static friction {}; give --friction-static at least as much", variant.friction_dynamic,
                variant.friction_static);
  }
  return {};
}

Result<bool> stress_tools(const StressOptions& options) {
  const auto bodies = make_bodies(options);
  if (!bodies) return tl::unexpected(bodies.error());
  ToolStressPlan plan{.seed = options.plan.seed, .steps = options.plan.steps * bodies->size()};
  plan.moving = options.moving;
  if (options.scale) plan.scales = {*options.scale};
  fmt::print("stress: rigid tools, {} bodies{}, {} scales, at least {} steps a body, seed {}\n", bodies->size(),
             plan.moving ? " that move" : "", plan.scales.size(), options.plan.steps, plan.seed);
  std::fflush(stdout);
  std::size_t done = 0;
  const auto results = run_tool_stress(*bodies, plan, [&](const ToolStressResult& result) {
    fmt::print(stderr, "[{}/{}] {}: {} steps, {} faults\n", ++done, bodies->size(), result.body, result.count.steps, result.count.faults());
  });
  if (!results) return tl::unexpected(results.error());
  fmt::print("{}", to_text(*results));
  std::uint64_t steps = 0;
  std::uint64_t faults = 0;
  for (const ToolStressResult& result : *results) {
    steps += result.count.steps;
    faults += result.count.faults();
  }
  fmt::print("stress: {} faults in {} steps, seed {}\n", faults, steps, plan.seed);
  return faults == 0;
}

Result<bool> run_stress(StressOptions& options) {
  if (auto chosen = choose_variant(options); !chosen) return tl::unexpected(chosen.error());
  const auto bodies = make_bodies(options);
  if (!bodies) return tl::unexpected(bodies.error());
  fmt::print("stress: method {}, {} bodies, {} variants, at least {} steps a body, seed {}\n",
             options.plan.by_patches ? "proxy by patches" : options.plan.method.name, bodies->size(), options.plan.variants.size(),
             options.plan.steps, options.plan.seed);
  std::fflush(stdout);
  const std::size_t jobs = bodies->size() * options.plan.variants.size();
  std::size_t done = 0;
  const auto results =
      options.episode ? run_episode(*bodies, options.plan, *options.episode)
                      : run_stress(*bodies, options.plan, [&](const StressResult& result) {
                          fmt::print(stderr, "[{}/{}] {} x{:g} +{:g}: {} steps, {} faults\n", ++done, jobs, result.body,
                                     result.variant.scale, result.variant.offset_extents, result.count.steps, result.count.total_faults());
                        });
  if (!results) return tl::unexpected(results.error());
  fmt::print("{}", to_text(*results, options.plan));
  const StressCount sum = sum_of(*results);
  if (sum.steps == 0)
    return fail("no step was made: no start was free of contact; give a smaller --probe-share, or another --scale or --offset");
  fmt::print("stress: {} faults in {} steps, seed {}\n", sum.total_faults(), sum.steps, options.plan.seed);
  if (!options.out.empty()) {
    if (auto written = write_file_atomically(options.out + "/stress.json", to_json(*results, options.plan)); !written)
      return tl::unexpected(written.error());
  }
  return sum.total_faults() == 0;
}

// Adds the options that say what is tested and for how long.
void add_method_and_bodies(const CommandLine& command, StressOptions& options) {
  StressPlan& plan = options.plan;
  command.add_option("--method", plan.method.name, "Force method, one of: " + method_names()).one_of_names(method_names()).shows_default();
  command
      .add_option("--layer", plan.method.smooth_layer,
                  "smooth: share of RADIUS over which force builds up outside the surface; 1: Algorithm 1 of the FDH paper")
      .between(0.0, 1.0)
      .shows_default();
  command
      .add_option("--steps", plan.steps,
                  "Minimum number of steps for each body, over all scales and places together; an episode of up to 400 steps is never "
                  "shortened. If one scale gets 10,000 steps or more, walks of 20,000 steps follow")
      .positive()
      .shows_default();
  command.add_option("--seed", plan.seed, "Seed of every random choice").shows_default();
  command.add_option("--body", options.bodies, "Only this body, may be repeated: " + body_names())
      .one_of_names(body_names(), [](const std::string& name) { return is_mesh_file_name(name); });
  command.add_option("--mesh", options.files, "A mesh file in place of the bodies, may be repeated");
  command.add_flag("--no-seal", plan.no_seal, "Touch mesh files as they are: cracks up to 1e-4 of the longest side are not sealed");
}

}  // namespace

void add_stress_command(CommandLine app, int& exit_code) {
  auto options = std::make_shared<StressOptions>();
  options->plan.method.name = "proxy";
  options->plan.threads = std::max(1U, std::thread::hardware_concurrency());
  const CommandLine command =
      app.add_subcommand("stress", "Run a numerical stress test of a force method; exit code 0 only without faults");
  add_method_and_bodies(command, *options);
  const CommandOption patches = command.add_flag(
      "--patches", options->plan.by_patches,
      "Compute the force from patches of each body, as io_node --touch patch does, at its own scale and place, without and with friction");
  const CommandOption tool =
      command.add_flag("--tool", options->tool, "Press rigid tools of six shapes on each body instead: penetration by exact signs, gaps");
  command.add_flag("--moving", options->moving, "With --tool: the bodies move, next to a stationary ball").needs(tool);
  tool.excludes(patches);
  const CommandOption on_grid = command.add_flag("--on-grid", options->plan.on_grid,
                                                 "Round the vertices to the grid of patches first, and use the whole body: a fault that "
                                                 "--patches finds as well is not caused by patches");
  on_grid.excludes(patches);
  on_grid.excludes(tool);
  const CommandOption probe_share =
      command.add_option("--probe-share", options->plan.probe_share, "Probe radius as a share of the longest side; 0: as the body says");
  probe_share.between(0.0, 1.0);
  const CommandOption scale = command.add_option("--scale", options->scale, "Only this scale").positive();
  const CommandOption offset = command.add_option("--offset", options->offset, "Only this offset, in extents").between(0.0, 1e12);
  for (const CommandOption& placing : {scale, offset}) patches.excludes(placing);
  const CommandOption friction_static =
      command.add_option("--friction-static", options->friction_static, "Only with this friction").between(0.0, kFrictionStaticLimit.most);
  const CommandOption friction_dynamic =
      command.add_option("--friction-dynamic", options->friction_dynamic, "Only with this friction, not above the static one")
          .between(0.0, kFrictionDynamicLimit.most);
  const CommandOption episode = command.add_option("--episode", options->episode, "Only this episode, as a finding names it");
  const CommandOption minimum_every =
      command.add_option("--minimum-every", options->plan.compare_every,
                         "Steps between two checks of the proxy's local minimum by the reference; 0: only where a fault is suspected");
  minimum_every.shows_default();
  command.add_old_option("--rest-every", minimum_every);
  command.add_option("--substeps", options->plan.method.reference_substeps, "Sub-steps of --method reference")
      .between(1, 10000)
      .shows_default();
  command.add_option("--threads", options->plan.threads, "Combinations of body, scale, place and friction tested in parallel")
      .between(1, 1024)
      .shows_default();
  const CommandOption out = command.add_option("--out", options->out, "Folder for stress.json").folder_to_write();
  for (const CommandOption& of_a_probe : {offset, probe_share, friction_static, friction_dynamic, episode, out}) tool.excludes(of_a_probe);
  command.on_run([options, &exit_code] {
    const auto clean = options->tool ? stress_tools(*options) : run_stress(*options);
    if (!clean) fmt::print(stderr, "hapton stress: {}\n", clean.error().what);
    exit_code = clean && *clean ? 0 : 1;
  });
}

}  // namespace hapton
