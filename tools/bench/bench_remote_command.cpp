#include <fmt/core.h>

#include <cstdio>
#include <filesystem>
#include <memory>

#include "core/base/similar_word.h"
#include "runtime/atomic_file.h"
#include "runtime/clock.h"
#include "runtime/writable_path.h"
#include "tools/bench/remote_processes.h"
#include "tools/bench/remote_report.h"
#include "tools/commands.h"
#include "tools/loop/loop_flags.h"

namespace hapton {
namespace {

struct RemoteOptions {
  LoopFlags loop;
  std::vector<std::string> meshes;
  std::string folder;
  std::string methods;  // for this and the next three, as for meshes, empty means: as in RemoteDefaults
  std::string speeds;
  std::string round_trips;
  std::string losses;
  double jitter_ms = 0.0;
  double stall_ms = 0.0;
  double stiffness_n_per_m = 1000.0;
  std::uint64_t seed = 1;
  std::size_t seeds = 1;
  RemoteSettings settings;
  bool quick = false;
  bool no_walls = false;
  bool processes = false;
  bool json = false;
  std::filesystem::path csv;
  std::filesystem::path plot;
  std::filesystem::path trace;
};

// The values of the options that are not given.
struct RemoteDefaults {
  std::vector<std::string> meshes;
  std::string methods;
  std::string speeds;
  std::string round_trips;
  std::string losses;
};
RemoteDefaults defaults_of(const RemoteOptions& options) {
  RemoteDefaults defaults = {
      {"nefertiti_70k.ply", "fish_22k.obj", "car_body_20k.glb"}, "all", "100,300", "0,10,30,100,300,1000", "0,0.1,0.3"};
  if (options.processes) defaults = {{"nefertiti_70k.ply", "fish_22k.obj"}, "remote,patch", "100", "0,10,30,100,300,1000", "0.1"};
  if (!options.quick) return defaults;
  return {{"fish_22k.obj"}, defaults.methods, "100", "0,100,1000", "0.1"};
}

Result<std::vector<double>> read_scaled(const std::string& flag, const std::string& text, double most, double scale) {
  auto numbers = read_numbers(flag, text);
  if (!numbers) return numbers;
  for (double& number : *numbers) {
    if (!(number >= 0.0 && number <= most)) return fail("{}: {:g} is not between 0 and {:g}", flag, number, most);
    number *= scale;
  }
  return numbers;
}

Result<std::vector<const RemoteMethod*>> read_methods(const std::string& text) {
  std::vector<const RemoteMethod*> methods;
  std::vector<std::string_view> known;
  for (const RemoteMethod& method : remote_methods()) known.push_back(method.name);
  for (const std::string& name : split_list(text)) {
    if (name == "all") {
      for (const RemoteMethod& method : remote_methods()) methods.push_back(&method);
    } else if (const RemoteMethod* method = find_remote_method(name)) {
      methods.push_back(method);
    } else {
      return fail("--method '{}' is unknown{}", name, similar_word_hint(name, known));
    }
  }
  if (methods.empty()) return fail("--method: no name is given; known are {}, and all", remote_method_names());
  return methods;
}

Result<void> set_device(const RemoteOptions& options, RemoteGrid& grid) {
  if (options.loop.mass_kg) return fail("a device with limits is needed: give --device, not --mass-kg");
  const auto loops = loops_of(options.loop);
  if (!loops) return tl::unexpected(loops.error());
  const NamedLoop& loop = loops->front();
  if (!(loop.hand_model.stiffness_n_per_m > 0.0)) return fail("--hand {}: a hand without a spring cannot follow a path", loop.hand);
  grid.device_name = loop.title();
  grid.device = {loop.device_model, loop.limits, loop.hand_model};
  return {};
}

Result<RemoteGrid> make_grid(const RemoteOptions& options) {
  RemoteGrid grid;
  const RemoteDefaults defaults = defaults_of(options);
  const auto or_default = [](const auto& given, const auto& otherwise) { return given.empty() ? otherwise : given; };
  grid.meshes = or_default(options.meshes, defaults.meshes);
  grid.mesh_folder = options.folder.empty() ? find_mesh_folder() : std::filesystem::path(options.folder);
  auto methods = read_methods(or_default(options.methods, defaults.methods));
  if (!methods) return tl::unexpected(methods.error());
  grid.methods = std::move(*methods);
  const auto assign = [](std::vector<double>& into, Result<std::vector<double>> from) -> Result<void> {
    if (!from) return tl::unexpected(from.error());
    into = std::move(*from);
    return {};
  };
  auto assigned = assign(grid.speeds_m_per_s, read_scaled("--speed", or_default(options.speeds, defaults.speeds), 1000.0, 1e-3));
  if (assigned)
    assigned = assign(grid.round_trips_s, read_scaled("--round-trip", or_default(options.round_trips, defaults.round_trips), 5000.0, 1e-3));
  if (assigned) assigned = assign(grid.losses, read_scaled("--loss", or_default(options.losses, defaults.losses), 0.9, 1.0));
  if (assigned) assigned = set_device(options, grid);
  if (!assigned) return tl::unexpected(assigned.error());
  grid.jitter_s = 1e-3 * options.jitter_ms;
  grid.stall_s = 1e-3 * options.stall_ms;
  grid.seed = options.seed;
  grid.seeds = options.seeds;
  grid.stiffness_n_per_m = options.stiffness_n_per_m;
  grid.settings = options.settings;
  grid.has_walls = !options.no_walls;
  return grid;
}

Result<void> run_processes(const RemoteOptions& options, const RemoteGrid& grid, const std::function<void(const std::string&)>& progress) {
  const auto rows = measure_remote_processes(grid, progress);
  if (!rows) return tl::unexpected(rows.error());
  fmt::print("{}", options.json ? processes_to_json(grid, *rows) : processes_to_text(grid, *rows));
  return options.csv.empty() ? Result<void>() : write_file_atomically(options.csv, processes_to_csv(*rows));
}

// The path of the CSV file for the walls, beside the --csv file.
std::filesystem::path walls_csv_path(const std::filesystem::path& csv) {
  std::filesystem::path walls = csv;
  if (!csv.empty()) walls.replace_filename(csv.stem().string() + "_walls.csv");
  return walls;
}

Result<void> run(const RemoteOptions& options) {
  const auto differ =
      check_different_outputs({{"--csv", options.csv}, {"the walls of --csv", walls_csv_path(options.csv)}, {"--plot", options.plot}});
  if (!differ) return differ;
  const auto grid = make_grid(options);
  if (!grid) return tl::unexpected(grid.error());
  if (!options.trace.empty()) {
    const auto trace = trace_remote(*grid);
    return trace ? write_file_atomically(options.trace, *trace) : tl::unexpected(trace.error());
  }
  const SteadyClock clock;
  const std::int64_t start_ns = clock.now_ns();
  const auto progress = [&](const std::string& what) { print_progress(1e-9 * static_cast<double>(clock.now_ns() - start_ns), what); };
  if (options.processes) return run_processes(options, *grid, progress);
  const auto results = measure_remote(*grid, progress);
  if (!results) return tl::unexpected(results.error());
  fmt::print("{}", options.json ? to_json(*grid, *results) : to_text(*grid, *results));
  if (!options.csv.empty()) {
    if (auto written = write_file_atomically(options.csv, to_csv(*results)); !written) return written;
    if (grid->has_walls) {
      if (auto written = write_file_atomically(walls_csv_path(options.csv), walls_to_csv(*results)); !written) return written;
    }
  }
  if (options.plot.empty()) return {};
  const auto drawn = draw_remote_plot(options.plot, *grid, *results);
  return drawn ? Result<void>() : tl::unexpected(drawn.error());
}

}  // namespace

void add_bench_remote_command(CommandLine bench, int& exit_code) {
  auto options = std::make_shared<RemoteOptions>();
  options->loop.device = "premium-1.5";
  const CommandLine command =
      bench.add_subcommand("remote", "Ways to touch across a slow network, in simulated time: force error, energy, stability, packets");
  add_loop_flags(command, options->loop, false);
  command.add_option(
      "--mesh", options->meshes,
      "Mesh files, by path or name in the mesh folder, each scaled to 100 mm, or bumpy:N (default: three of 20 k to 70 k triangles)");
  command.add_option("--meshes-in", options->folder, "The mesh folder (default: ./meshes, else the source tree's)");
  command.add_option("--method", options->methods, "Ways to touch: all (default), or a list of " + remote_method_names());
  command.add_option("--speed", options->speeds, "Speed of the sliding hand, mm/s; a list or range (default: 100,300)");
  command.add_option("--round-trip", options->round_trips, "Round trip of the network, ms; a list or range (default: 0 to 1000, six)");
  command.add_option("--loss", options->losses, "Share of the datagrams lost each way; a list or range (default: 0,0.1,0.3)");
  command.add_option("--jitter", options->jitter_ms, "Random extra delay each way, up to this, ms").between(0.0, 1000.0).shows_default();
  const CommandOption stall = command
                                  .add_option("--stall", options->stall_ms,
                                              "Mean length of the stalls of the device's machine, about five a second, ms; for the "
                                              "force on a given path only, not for energy and stiffness")
                                  .between(0.0, 1000.0)
                                  .shows_default();
  command.add_option("--stiffness", options->stiffness_n_per_m, "Stiffness of the surface, N/m").between(1.0, 1e6).shows_default();
  command
      .add_option("--deadband", options->settings.deadband,
                  "Deadband coding sends a value that differs by more than this share (Weber fraction)")
      .between(0.0, 1.0)
      .shows_default();
  command.add_option("--seed", options->seed, "First seed of trajectories and networks").shows_default();
  command.add_option("--seeds", options->seeds, "Number of seeds").between(std::size_t{1}, std::size_t{1000}).shows_default();
  command.add_flag("--quick", options->quick, "One small mesh, speed, seed and loss, three round trips: about a minute");
  command.add_flag("--no-walls", options->no_walls, "Do not search for the largest stable stiffness");
  command.add_flag("--json", options->json, "Print JSON in place of tables");
  command.add_option("--csv", options->csv, "Write a line for each run to this file, and the walls to NAME_walls.csv").file_to_write();
  const CommandOption plot =
      command.add_option("--plot", options->plot, "Draw force error and stiffness against round trip as this PNG").file_to_write();
  const CommandOption trace =
      command
          .add_option(
              "--trace", options->trace,
              "Write forces period by period to this CSV file and measure nothing else: first mesh, seed, speed, round trip and loss")
          .file_to_write();
  command
      .add_flag("--processes", options->processes,
                "Also measure the real programs over hapton relay on this host: ten minutes (default: remote, patch; 100 mm/s, "
                "loss 0.1)")
      .excludes(plot)
      .excludes(stall)
      .excludes(trace);
  command.on_run([options, &exit_code] {
    const auto done = run(*options);
    if (!done) fmt::print(stderr, "hapton bench remote: {}\n", done.error().what);
    exit_code = done ? 0 : 1;
  });
}

}  // namespace hapton
