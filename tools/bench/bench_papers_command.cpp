#include <fmt/core.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>

#include "bench/papers/papers_run.h"
#include "runtime/atomic_file.h"
#include "runtime/clock.h"
#include "tools/bench/bench_meshes.h"
#include "tools/bench/papers_nodes.h"
#include "tools/commands.h"

namespace hapton {
namespace {

struct PapersOptions {
  std::filesystem::path out = "out/papers";
  std::string folder;
  std::string car = "car_front_3300.obj";
  std::string mesh = "car_body_20k.glb";
  PapersSettings settings;
  bool quick = false;
  bool without_nodes = false;
  bool json = false;
  bool csv = false;
};

Result<void> write(const PapersReport& report, const std::filesystem::path& folder) {
  const std::pair<const char*, std::string> files[] = {{"papers.txt", to_text(report)},
                                                       {"papers.csv", to_csv(report)},
                                                       {"papers_tasks.csv", tasks_csv(report)},
                                                       {"papers_hulls.csv", hulls_csv(report)},
                                                       {"papers.json", to_json(report)}};
  for (const auto& [name, text] : files) {
    if (auto written = write_file_atomically(folder / name, text); !written) return written;
  }
  return {};
}

Result<PapersMesh> load(const std::string& mesh_spec, const PapersOptions& options) {
  auto mesh = make_bench_mesh(mesh_spec, options.folder.empty() ? find_mesh_folder() : std::filesystem::path(options.folder));
  if (!mesh) return tl::unexpected(mesh.error());
  return PapersMesh{mesh->name, mesh->mesh};
}

Result<PapersReport> measure(PapersOptions& options) {
  if (auto writable = ensure_writable_folder(options.out); !writable) return tl::unexpected(writable.error());
  if (options.quick) {
    options.settings.steps = 2000;
    options.settings.touch_seconds = 4.0;
    options.settings.hapton_seconds = 1.0;
    options.settings.budget = {.repetitions = 2, .seconds = 0.5};
  }
  const auto car = load(options.car, options);
  if (!car) return tl::unexpected(car.error());
  const auto mesh = load(options.mesh, options);
  if (!mesh) return tl::unexpected(mesh.error());
  const Stopwatch watch = Stopwatch::calibrate();
  const std::uint64_t start = Stopwatch::ticks();
  const SteadyClock clock;
  const std::int64_t start_ns = clock.now_ns();
  const auto progress = [&](const std::string& what) { print_progress(1e-9 * static_cast<double>(clock.now_ns() - start_ns), what); };
  PapersReport report = make_papers_report();
  report.conditions = begin_conditions(watch, options.settings.seed);
  if (options.without_nodes) report.leave_out_nodes();
  if (auto done = measure_papers(options.settings, watch, *car, *mesh, progress, report); !done) return tl::unexpected(done.error());
  if (!options.without_nodes) {
    progress("stereo, round trip and system latency: the nodes");
    PapersNodesSettings nodes;
    nodes.out = options.out / "nodes";
    nodes.scene = find_mesh_folder().parent_path() / "scenes" / "car_front.toml";
    if (options.quick) nodes.frames = 40;
    if (options.quick) nodes.seconds = 4.0;
    measure_paper_nodes(nodes, report);
  }
  end_conditions(report.conditions, start, watch);
  if (auto written = write(report, options.out); !written) return tl::unexpected(written.error());
  return report;
}

int run_papers(PapersOptions& options) {
  const auto report = measure(options);
  if (!report) {
    fmt::print(stderr, "hapton bench papers: {}\n", report.error().what);
    return 1;
  }
  fmt::print("{}", options.json ? to_json(*report) : options.csv ? to_csv(*report) : to_text(*report));
  fmt::print(stderr, "{:.0f} s; papers.txt, papers.csv, papers_tasks.csv, papers_hulls.csv and papers.json are in {}\n",
             report->conditions.seconds, options.out.string());
  if (report->is_complete()) return 0;
  for (const PaperRow& row : report->rows) {
    if (!row.ours) fmt::print(stderr, "hapton bench papers: {}: {}\n", row.what, row.how);
  }
  return 1;
}

}  // namespace

void add_bench_papers_command(CommandLine bench, int& exit_code) {
  auto options = std::make_shared<PapersOptions>();
  const CommandLine command = bench.add_subcommand("papers", "Both papers' own figures measured again: paper, ours, ratio");
  command.add_flag("--quick", options->quick, "Short runs: about half a minute");
  command.add_flag("--no-nodes", options->without_nodes, "Leave out the figures that need io_node, haptics_node and vision_node");
  const CommandOption json = command.add_flag("--json", options->json, "Print the JSON report instead of the table");
  command.add_flag("--csv", options->csv, "Print the CSV table instead").excludes(json);
  command.add_option("--mesh", options->mesh, "Mesh for the FDH paper's figures (its models have about 20,000 triangles)").shows_default();
  command.add_option("--car", options->car, "Mesh for the memo's figures (its car has 3300 polygons)").shows_default();
  command.add_option("--meshes-in", options->folder, "The mesh folder (default: ./meshes, else the source tree's)");
  command.add_option("--seed", options->settings.seed, "Seed of slides and pairs").shows_default();
  command.add_option("--out", options->out, "Folder for the reports and the nodes' logs").folder_to_write().shows_default();
  command.on_run([options, &exit_code] { exit_code = run_papers(*options); });
}

}  // namespace hapton
