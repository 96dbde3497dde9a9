#include <fmt/core.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bench/measure/own_structures.h"
#include "bench/measure/pareto_run.h"
#include "bench/peers/peer_structures.h"
#include "runtime/atomic_file.h"
#include "runtime/clock.h"
#include "tools/bench/bench_meshes.h"
#include "tools/bench/pareto_plot.h"
#include "tools/commands.h"

namespace hapton {
namespace {

struct ParetoOptions {
  std::vector<std::string> meshes;
  std::string folder;
  std::filesystem::path out;
  ParetoSettings settings;
  bool quick = false;
  bool all = false;
};

const std::vector<std::string> kQuickMeshes = {"car_front_3300.obj", "bumpy:20000"};
const std::vector<std::string> kUsualMeshes = {"car_front_3300.obj", "car_body_20k.glb", "nefertiti_70k.ply",
                                               "skull_100k.ply",     "bumpy:20000",      "bumpy:1000000"};
const std::vector<std::string> kAllMeshes = {"car_front_3300.obj",    "demosthenes_17k_open.obj",
                                             "car_body_20k.glb",      "fish_22k.obj",
                                             "mountain_51k_open.ply", "nefertiti_70k.ply",
                                             "skull_100k.ply",        "bumpy:5000",
                                             "bumpy:20000",           "bumpy:80000",
                                             "bumpy:300000",          "bumpy:1000000"};

Result<void> write(const ParetoOptions& options, const ParetoReport& report) {
  if (auto written = write_file_atomically(options.out / "pareto.csv", to_csv(report)); !written) return written;
  return write_file_atomically(options.out / "pareto.json", to_json(report));
}

Result<void> measure(ParetoOptions& options) {
  if (auto writable = ensure_writable_folder(options.out); !writable) return writable;
  if (options.quick) {
    options.settings.steps = std::min<std::size_t>(options.settings.steps, 2000);
    options.settings.compared_steps = 500;
    options.settings.budget = {.repetitions = 3, .seconds = 0.15};
  }
  const std::vector<std::string> meshes = !options.meshes.empty() ? options.meshes
                                          : options.all           ? kAllMeshes
                                          : options.quick         ? kQuickMeshes
                                                                  : kUsualMeshes;
  const std::filesystem::path folder = options.folder.empty() ? find_mesh_folder() : std::filesystem::path(options.folder);
  std::vector<QueryStructureKind> structures = own_structures();
  for (QueryStructureKind& kind : peer_structures()) structures.push_back(std::move(kind));
  const Stopwatch watch = Stopwatch::calibrate();
  const std::uint64_t start = Stopwatch::ticks();
  const SteadyClock clock;
  const std::int64_t start_ns = clock.now_ns();
  const Progress progress = [&](const std::string& what) { print_progress(1e-9 * static_cast<double>(clock.now_ns() - start_ns), what); };
  ParetoReport report;
  report.conditions = begin_conditions(watch, options.settings.seed);
  report.conditions.missing_peers = missing_peers();
  for (const std::string& which : meshes) {
    const auto mesh = make_bench_mesh(which, folder);
    if (!mesh) return tl::unexpected(mesh.error());
    if (auto done = measure_pareto(options.settings, watch, mesh->name, mesh->mesh, structures, progress, report); !done) return done;
    end_conditions(report.conditions, start, watch);
    fmt::print("{}\n", to_text(report, mesh->name));
    std::fflush(stdout);
    if (auto written = write(options, report); !written) return written;
  }
  const auto picture = draw_pareto_plot(options.out, pareto_marks(report));
  if (!picture) return tl::unexpected(picture.error());
  fmt::print("{}\n{:.0f} s; pareto.csv, pareto.json and pareto.png are in {}\n", report.conditions.to_text(), report.conditions.seconds,
             options.out.string());
  return {};
}

}  // namespace

void add_bench_pareto_command(CommandLine bench, int& exit_code) {
  auto options = std::make_shared<ParetoOptions>();
  const CommandLine command =
      bench.add_subcommand("pareto", "Run time against force error: every method and structure over several meshes, and a plot");
  const CommandLine which =
      command.add_group("meshes", "Which meshes, each scaled to 100 mm (default: six, 3 k to 1.3 M triangles)").require_options(0, 1);
  which.add_option("--mesh", options->meshes,
                   "Mesh files, by path or name in the mesh folder, or bumpy:N for a bumpy sphere of N triangles");
  which.add_flag("--all", options->all, "Twelve meshes");
  command.add_flag("--quick", options->quick, "Short runs, over two small meshes unless others are named: less than a minute");
  command.add_option("--meshes-in", options->folder, "The mesh folder (default: ./meshes, else the source tree's)");
  command.add_option("--steps", options->settings.steps, "Steps of the slide over each mesh").between(100, 10'000'000).shows_default();
  const CommandOption compared =
      command.add_option("--compared-steps", options->settings.compared_steps, "Number of these steps that are compared with the reference")
          .between(10, 10'000'000)
          .shows_default();
  command.add_old_option("--judged-steps", compared);
  command.add_option("--seed", options->settings.seed, "Seed of the slides").shows_default();
  command.add_option("--out", options->out, "Folder for pareto.csv, pareto.json and pareto.png").folder_to_write().required();
  command.on_run([options, &exit_code] {
    const auto done = measure(*options);
    if (!done) fmt::print(stderr, "hapton bench pareto: {}\n", done.error().what);
    exit_code = done ? 0 : 1;
  });
}

}  // namespace hapton
