#include <fmt/core.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "runtime/atomic_file.h"
#include "runtime/writable_path.h"
#include "tools/commands.h"
#include "tools/loop/zwidth_grid.h"
#include "tools/loop/zwidth_plot.h"

namespace hapton {
namespace {

struct ZWidthOptions {
  LoopFlags loop;
  std::string rates = "1000";
  std::string delays = "0";
  std::string jitters = "0";
  std::string losses = "0";
  std::string wall_dampings = "0";
  std::string shard = "1/1";
  std::uint64_t seed = 1;
  double mass_filter_s = MassEffect().filter_s;
  std::filesystem::path csv;
  std::filesystem::path plot;
  bool presses = false;
  bool json = false;
};

Result<std::vector<double>> read_range(const std::string& flag, const std::string& text, double least, double most, const char* unit) {
  auto numbers = read_numbers(flag, text);
  if (!numbers) return numbers;
  for (const double number : *numbers) {
    if (number < least || number > most) return fail("{}: {} is not between {} and {} {}", flag, number, least, most, unit);
  }
  return numbers;
}

Result<ZWidthGrid> make_grid(const ZWidthOptions& options) {
  ZWidthGrid grid;
  auto loops = loops_of(options.loop);
  if (!loops) return tl::unexpected(loops.error());
  grid.loops = std::move(*loops);
  const auto fill = [](std::vector<double>& into, Result<std::vector<double>> from) -> Result<void> {
    if (!from) return tl::unexpected(from.error());
    into = std::move(*from);
    return {};
  };
  auto filled = fill(grid.rates_hz, read_range("--rate", options.rates, 10.0, 1e6, "Hz"));
  if (filled) filled = fill(grid.delays_ms, read_range("--delay", options.delays, 0.0, 10'000.0, "ms"));
  if (filled) filled = fill(grid.jitters_ms, read_range("--jitter", options.jitters, 0.0, 10'000.0, "ms"));
  if (filled) filled = fill(grid.losses, read_range("--loss", options.losses, 0.0, 0.99, "as a share"));
  grid.seed = options.seed;
  grid.measures_presses = options.presses;
  grid.mass_filter_s = options.mass_filter_s;
  if (filled) filled = fill(grid.wall_dampings_ns_per_m, read_range("--wall-damping", options.wall_dampings, 0.0, 1e6, "Ns/m"));
  if (!filled) return tl::unexpected(filled.error());
  return grid;
}

std::string to_text(const ZWidthRow& row) {
  const bool is_random = row.is_simulated();
  const std::string inputs =
      fmt::format("{}, {:g} Hz, {:g} ms{}", row.loop->title(), row.inputs.rate_hz, row.delay_ms,
                  is_random ? fmt::format(", jitter {:g} ms, loss {:g}, seed {}", row.jitter_ms, row.loss, row.seed) : "");
  if (!std::isfinite(row.mean_delay_s)) return inputs + ": no force came back within the simulated time\n";
  return fmt::format(
      "{}: stable up to {:.6g} N/m{}, passive up to {:.6g} N/m{}{}; linear rule {:.6g} N/m{}\n", inputs, row.zwidth.stiffness.value,
      is_random ? "" : fmt::format(" (oscillates at {:.3g} Hz)", row.zwidth.stiffness.frequency_hz), row.zwidth.passive.least_n_per_m(),
      is_random ? fmt::format(" on average (mean delay {:.4g} ms)", 1e3 * row.mean_delay_s) : "",
      row.rest_stiffness_n_per_m ? fmt::format(", a press comes to rest up to {:.4g} N/m", *row.rest_stiffness_n_per_m) : "",
      row.zwidth.linear_rule_n_per_m, is_random ? "" : fmt::format("; virtual mass stable up to {:.3g} kg", row.zwidth.mass_kg.value));
}

Result<void> run(const ZWidthOptions& options) {
  const auto differ = check_different_outputs({{"--csv", options.csv}, {"--plot", options.plot}});
  if (!differ) return differ;
  const auto grid = make_grid(options);
  if (!grid) return tl::unexpected(grid.error());
  const auto shard = read_shard(options.shard);
  if (!shard) return tl::unexpected(shard.error());
  std::vector<ZWidthRow> rows;
  std::string csv = csv_header(*grid);
  nlohmann::ordered_json cells = nlohmann::ordered_json::array();
  for (std::size_t cell = 0; cell < grid->cells(); ++cell) {
    if (!shard->has(cell)) continue;
    const ZWidthRow row = measure_cell(*grid, cell);
    if (!options.csv.empty()) csv += csv_line(row);
    if (!options.plot.empty()) rows.push_back(row);
    if (options.json) {
      cells.push_back(to_json(row));
    } else if (options.csv.empty() && options.plot.empty()) {
      fmt::print("{}", to_text(row));
    }
  }
  if (options.json) fmt::print("{}\n", (cells.size() == 1 ? cells.front() : cells).dump(2));
  if (!options.csv.empty()) {
    if (auto written = write_file_atomically(options.csv, csv); !written) return written;
  }
  if (options.plot.empty()) return {};
  const auto drawn = draw_zwidth_plot(options.plot, *grid, rows);
  return drawn ? Result<void>() : tl::unexpected(drawn.error());
}

}  // namespace

void add_loop_zwidth_command(CommandLine loop, int& exit_code) {
  auto options = std::make_shared<ZWidthOptions>();
  const CommandLine command = loop.add_subcommand("zwidth", "Largest stable and largest passive stiffness and damping");
  add_loop_flags(command, options->loop, true);
  command.add_option("--rate", options->rates, "Servo rate, Hz; a list a,b or a range LOW:HIGH:COUNT or LOW:HIGH:COUNTlog").shows_default();
  command.add_option("--delay", options->delays, "From the sample to its force on the motors, ms; a list or range").shows_default();
  command.add_option("--jitter", options->jitters, "Random extra delay each way, up to this, drawn for each datagram, ms; a list or range")
      .shows_default();
  command.add_option("--loss", options->losses, "Share of the datagrams lost each way; a list or range").shows_default();
  command.add_option("--seed", options->seed, "Seed of jitter and loss").shows_default();
  command.add_option("--wall-damping", options->wall_dampings, "Damping of the wall by finite difference, Ns/m; a list or range")
      .shows_default();
  command.add_option("--mass-filter", options->mass_filter_s, "Filter of a virtual mass, s (docs/effects.md)")
      .between(MassEffect::kMinFilterS, 1.0)
      .shows_default();
  command.add_option("--shard", options->shard, "Only part I of N of the grid, as I/N").shows_default();
  command.add_flag("--press", options->presses,
                   "Simulate presses too, with encoder steps, friction and saturation: the largest stiffness at which one comes to rest");
  command.add_option("--csv", options->csv, "Write a line for each cell to this file").file_to_write();
  command.add_option("--plot", options->plot, "Draw stiffness against delay, or against rate where there is one delay, as this PNG")
      .file_to_write();
  command.add_flag("--json", options->json, "Print JSON: an object, or a list of them");
  command.on_run([options, &exit_code] {
    const auto done = run(*options);
    if (!done) fmt::print(stderr, "hapton loop zwidth: {}\n", done.error().what);
    exit_code = done ? 0 : 1;
  });
}

void add_loop_merge_command(CommandLine loop, int& exit_code) {
  struct MergeOptions {
    std::vector<std::string> parts;
    std::filesystem::path out;
  };
  auto options = std::make_shared<MergeOptions>();
  const CommandLine command = loop.add_subcommand("merge", "Join the CSV files of all shards of a grid");
  command.add_option("parts", options->parts, "CSV files, one a shard").required();
  command.add_option("--out", options->out, "File for the whole grid").file_to_write().required();
  command.on_run([options, &exit_code] {
    const auto merged = merge_csv({options->parts.begin(), options->parts.end()});
    const auto done = merged ? write_file_atomically(options->out, *merged) : Result<void>(tl::unexpected(merged.error()));
    if (!done) fmt::print(stderr, "hapton loop merge: {}\n", done.error().what);
    exit_code = done ? 0 : 1;
  });
}

}  // namespace hapton
