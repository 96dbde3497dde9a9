#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "closed_loop/zwidth.h"
#include "core/base/result.h"
#include "tools/loop/loop_flags.h"

namespace hapton {

// Every combination of these: the last list runs fastest.
struct ZWidthGrid {
  std::vector<NamedLoop> loops;
  std::vector<double> rates_hz = {1000.0};
  std::vector<double> delays_ms = {0.0};
  std::vector<double> jitters_ms = {0.0};
  std::vector<double> losses = {0.0};
  std::vector<double> wall_dampings_ns_per_m = {0.0};
  std::uint64_t seed = 1;
  double mass_filter_s = MassEffect().filter_s;  // of the virtual mass
  bool presses = false;                          // find the rest stiffness of each cell too

  std::size_t cells() const noexcept {
    return loops.size() * rates_hz.size() * delays_ms.size() * jitters_ms.size() * losses.size() * wall_dampings_ns_per_m.size();
  }
};

// One cell of a grid and what was found there.
struct ZWidthRow {
  std::size_t cell = 0;
  const NamedLoop* loop = nullptr;
  ZWidthCase inputs;
  double delay_ms = 0.0;
  double jitter_ms = 0.0;  // of each way
  double loss = 0.0;       // of each way
  std::uint64_t seed = 1;
  double mean_delay_s = 0.0;  // of the force on the motors: the delay; with jitter or loss measured (closed_loop/random_stability.h)
  ZWidth found;
  std::optional<double> rest_n_per_m;  // closed_loop/press.h

  // With jitter or loss the limits of stability are simulated (closed_loop/random_stability.h), passivity is that of the mean delay, and
  // there is no limit of virtual mass: not a number.
  bool is_simulated() const noexcept { return jitter_ms > 0.0 || loss > 0.0; }
};

// Pre: cell < grid.cells(); the grid outlives the row.
ZWidthRow measure_cell(const ZWidthGrid& grid, std::size_t cell);

// Part `index` of `count` of a grid: every count-th cell, so that all parts take about as long.
struct Shard {
  std::size_t index = 1;
  std::size_t count = 1;
  bool has(std::size_t cell) const noexcept { return cell % count == index - 1; }
};

// "2/8". Error: none of these.
Result<Shard> read_shard(const std::string& text);

nlohmann::ordered_json to_json(const ZWidthRow& row);

// The first lines of a grid's CSV: what grid it is, and the columns.
std::string csv_header(const ZWidthGrid& grid);
std::string csv_line(const ZWidthRow& row);

// The parts of one grid as one CSV, in the order of its cells. Error: one that cannot be read or is of another grid; a cell that is missing
// or comes twice, with its number.
Result<std::string> merge_csv(const std::vector<std::filesystem::path>& parts);

}  // namespace hapton
