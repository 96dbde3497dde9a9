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

// A cell is one combination of these values; from cell to cell the last list varies fastest.
struct ZWidthGrid {
  std::vector<NamedLoop> loops;
  std::vector<double> rates_hz = {1000.0};
  std::vector<double> delays_ms = {0.0};
  std::vector<double> jitters_ms = {0.0};
  std::vector<double> losses = {0.0};
  std::vector<double> wall_dampings_ns_per_m = {0.0};
  std::uint64_t seed = 1;
  double mass_filter_s = MassEffect().filter_s;  // time constant of the filter of the virtual mass
  bool measures_presses = false;                 // also find the largest stiffness at which a press comes to rest

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
  double jitter_ms = 0.0;  // on each of the two ways of the link
  double loss = 0.0;       // likewise
  std::uint64_t seed = 1;
  double mean_delay_s = 0.0;  // from sample to force on the motors: delay_ms; measured with jitter or loss (closed_loop/random_stability.h)
  ZWidth zwidth;
  std::optional<double> rest_stiffness_n_per_m;  // found by find_rest_stiffness (closed_loop/press.h); none: not requested

  // With jitter or loss the limits of stability are simulated (closed_loop/random_stability.h), the passive stiffness is that of the mean
  // delay, and the limit of the virtual mass is not computed (NaN).
  bool is_simulated() const noexcept { return jitter_ms > 0.0 || loss > 0.0; }
};

// Pre: cell < grid.cells(); the grid outlives the row.
ZWidthRow measure_cell(const ZWidthGrid& grid, std::size_t cell);

// Part `index` of `count` of a grid: every count-th cell, so that all parts take about the same time.
struct Shard {
  std::size_t index = 1;
  std::size_t count = 1;
  bool has(std::size_t cell) const noexcept { return cell % count == index - 1; }
};

// Reads "2/8": part 2 of 8. Error: the text is not of this form, or the index is not from 1 to the count.
Result<Shard> read_shard(const std::string& text);

nlohmann::ordered_json to_json(const ZWidthRow& row);

// The first two lines of the CSV file of a grid: an identification of the grid, and the columns.
std::string csv_header(const ZWidthGrid& grid);
std::string csv_line(const ZWidthRow& row);

// Merges the CSV files of the parts of one grid, in the order of its cells. Error: a part that cannot be read or belongs to another grid, a
// line that does not begin with a cell of the grid, or a cell that is missing or occurs twice.
Result<std::string> merge_csv(const std::vector<std::filesystem::path>& parts);

}  // namespace hapton
