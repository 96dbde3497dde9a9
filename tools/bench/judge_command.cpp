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
#include "tools/bench/judge.h"
#include "tools/commands.h"
#include "tools/mesh_choice.h"
#include "tools/method_flags.h"
#include "tools/session/trajectory.h"

namespace hapton {
namespace {

struct JudgeOptions {
  MeshChoice mesh;
  std::string kind = "slide";
  std::string out;
  TrajectorySettings trajectory;
  MethodFlags method;
  JudgeSettings settings;
  Material material;
};

std::string to_csv(const Judgement& judgement, double rate_hz) {
  std::string text = "t_s,x_m,y_m,z_m,fx_n,fy_n,fz_n,reference_fx_n,reference_fy_n,reference_fz_n,reference_settled\n";
  for (std::size_t i = 0; i < judgement.method.size(); ++i) {
    fmt::format_to(std::back_inserter(text), "{:.6f}", static_cast<double>(i) / rate_hz);
    for (const Vec3& v : {judgement.method[i].device, judgement.method[i].force_n, judgement.reference[i].force_n}) {
      fmt::format_to(std::back_inserter(text), ",{:.17g},{:.17g},{:.17g}", v.x(), v.y(), v.z());
    }
    text += judgement.reference[i].settled ? ",1\n" : ",0\n";
  }
  return text;
}

Result<void> judge(const JudgeOptions& options) {
  const auto method = settings_of(options.method);
  if (!method) return tl::unexpected(method.error());
  auto mesh = make_mesh(options.mesh);
  if (!mesh) return tl::unexpected(mesh.error());
  const auto trajectory = make_trajectory(options.kind, *mesh, options.trajectory);
  if (!trajectory) return tl::unexpected(trajectory.error());
  fmt::print("judge: {} against the reference over {} ({} triangles), {} rows of {}, seed {}\n", method->name, name_of(options.mesh),
             mesh->triangles.size(), options.trajectory.rows, options.kind, options.trajectory.seed);
  std::fflush(stdout);
  TouchScene scene;
  scene.objects.push_back({std::make_shared<TriangleMesh>(std::move(*mesh)), options.material});
  JudgeSettings settings = options.settings;
  settings.method = *method;
  const auto judgement = judge_method(settings, scene, *trajectory);
  if (!judgement) return tl::unexpected(judgement.error());
  fmt::print("{}", to_text(*judgement));
  if (options.out.empty()) return {};
  if (auto written = write_file_atomically(options.out + "/judge.json", to_json(*judgement)); !written) return written;
  return write_file_atomically(options.out + "/judge.csv", to_csv(*judgement, options.trajectory.rate_hz));
}

}  // namespace

void add_judge_command(CommandLine app, int& exit_code) {
  auto options = std::make_shared<JudgeOptions>();
  options->settings.threads = std::max(1U, std::thread::hardware_concurrency());
  const CommandLine command = app.add_subcommand("judge", "Measure a method's force error against the brute-force reference");
  add_mesh_options(command, options->mesh);
  add_method_flags(command, options->method);
  command.add_option("--kind", options->kind, "Of trajectory: " + trajectory_kinds()).shows_default();
  command.add_option("--seed", options->trajectory.seed, "Of the trajectory").shows_default();
  command.add_option("--rows", options->trajectory.rows, "How many steps").between(1, 100'000'000).shows_default();
  command.add_option("--stiffness", options->material.stiffness_n_per_m, "N/m").positive().shows_default();
  command.add_option("--friction-static", options->material.friction_static, "Coulomb coefficient").not_negative().shows_default();
  command.add_option("--friction-dynamic", options->material.friction_dynamic, "Coulomb coefficient, not above the static one")
      .not_negative()
      .shows_default();
  command.add_option("--substeps", options->settings.substeps, "Of the reference, to begin with").between(1, 10000).shows_default();
  command.add_option("--substep-limit", options->settings.substep_limit, "Where the reference stops doubling its sub-steps")
      .between(1, 10000)
      .shows_default();
  command.add_option("--threads", options->settings.threads, "Segments judged at a time").between(1, 1024).shows_default();
  command.add_option("--out", options->out, "Folder for judge.json and judge.csv").folder_to_write();
  command.on_run([options, &exit_code] {
    const auto done = judge(*options);
    if (!done) fmt::print(stderr, "hapton judge: {}\n", done.error().what);
    exit_code = done ? 0 : 1;
  });
}

}  // namespace hapton
