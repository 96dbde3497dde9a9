#include <fmt/core.h>

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <iterator>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "core/geometry/mesh_measures.h"
#include "runtime/atomic_file.h"
#include "scene/material_limits.h"
#include "tools/bench/evaluate.h"
#include "tools/commands.h"
#include "tools/mesh_choice.h"
#include "tools/method_flags.h"
#include "tools/session/trajectory.h"

namespace hapton {
namespace {

struct EvaluateOptions {
  MeshChoice mesh;
  std::string kind = "slide";
  std::string out;
  TrajectorySettings trajectory;
  MethodFlags method;
  EvaluationSettings settings;
  Material material;
};

std::string to_csv(const Evaluation& evaluation, double rate_hz) {
  std::string text = "t_s,x_m,y_m,z_m,fx_n,fy_n,fz_n,reference_fx_n,reference_fy_n,reference_fz_n,reference_settled\n";
  for (std::size_t i = 0; i < evaluation.method.size(); ++i) {
    fmt::format_to(std::back_inserter(text), "{:.6f}", static_cast<double>(i) / rate_hz);
    for (const Vec3& v : {evaluation.method[i].device, evaluation.method[i].force_n, evaluation.reference[i].force_n}) {
      fmt::format_to(std::back_inserter(text), ",{:.17g},{:.17g},{:.17g}", v.x(), v.y(), v.z());
    }
    text += evaluation.reference[i].settled ? ",1\n" : ",0\n";
  }
  return text;
}

Result<void> evaluate(const EvaluateOptions& options) {
  const auto method = settings_of(options.method);
  if (!method) return tl::unexpected(method.error());
  auto mesh = make_mesh(options.mesh);
  if (!mesh) return tl::unexpected(mesh.error());
  const auto trajectory = make_trajectory(options.kind, *mesh, options.trajectory);
  if (!trajectory) return tl::unexpected(trajectory.error());
  fmt::print("evaluate: {} against the reference over {} ({} triangles), {} rows of {}, seed {}\n", method->name, name_of(options.mesh),
             mesh->triangles.size(), options.trajectory.rows, options.kind, options.trajectory.seed);
  std::fflush(stdout);
  TouchScene scene;
  scene.objects.push_back({std::make_shared<TriangleMesh>(std::move(*mesh)), options.material});
  EvaluationSettings settings = options.settings;
  settings.method = *method;
  const auto evaluation = evaluate_method(settings, scene, *trajectory);
  if (!evaluation) return tl::unexpected(evaluation.error());
  fmt::print("{}", to_text(*evaluation));
  if (options.out.empty()) return {};
  if (auto written = write_file_atomically(options.out + "/evaluation.json", to_json(*evaluation)); !written) return written;
  return write_file_atomically(options.out + "/evaluation.csv", to_csv(*evaluation, options.trajectory.rate_hz));
}

void set_up_command(CommandLine command, int& exit_code, const char* note) {
  auto options = std::make_shared<EvaluateOptions>();
  options->settings.threads = std::max(1U, std::thread::hardware_concurrency());
  add_mesh_options(command, options->mesh);
  add_method_flags(command, options->method);
  command.add_option("--kind", options->kind, "Kind of trajectory: " + trajectory_kinds()).one_of_names(trajectory_kinds()).shows_default();
  command.add_option("--seed", options->trajectory.seed, "Seed of the trajectory").shows_default();
  command.add_option("--rows", options->trajectory.rows, "Number of steps").between(1, 100'000'000).shows_default();
  command.add_option("--stiffness", options->material.stiffness_n_per_m, "N/m")
      .positive()
      .between(0.0, kStiffnessLimit.most)
      .shows_default();
  command.add_option("--friction-static", options->material.friction_static, "Static friction coefficient")
      .between(0.0, kFrictionStaticLimit.most)
      .shows_default();
  command.add_option("--friction-dynamic", options->material.friction_dynamic, "Dynamic friction coefficient, at most the static one")
      .between(0.0, kFrictionDynamicLimit.most)
      .shows_default();
  command
      .add_option("--substeps", options->settings.substeps,
                  "Sub-steps of the reference to begin with; it doubles them until its force no longer changes")
      .between(1, 10000)
      .shows_default();
  command.add_option("--substep-limit", options->settings.substep_limit, "Sub-steps at which the reference stops doubling")
      .between(1, 10000)
      .shows_default();
  command.add_option("--threads", options->settings.threads, "Segments evaluated in parallel").between(1, 1024).shows_default();
  command.add_option("--out", options->out, "Folder for evaluation.json and evaluation.csv").folder_to_write();
  command.on_run([options, &exit_code, note] {
    fmt::print(stderr, "{}", note);
    const auto done = evaluate(*options);
    if (!done) fmt::print(stderr, "hapton evaluate: {}\n", done.error().what);
    exit_code = done ? 0 : 1;
  });
}

}  // namespace

void add_evaluate_command(CommandLine app, int& exit_code) {
  set_up_command(app.add_subcommand("evaluate", "Measure a method's force error against the brute-force reference"), exit_code, "");
  set_up_command(app.add_old_subcommand("judge", "evaluate"), exit_code, "hapton judge is now hapton evaluate\n");
}

}  // namespace hapton
