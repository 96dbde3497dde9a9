#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bench/measure/run_conditions.h"
#include "bench/papers/hull_directions.h"
#include "bench/papers/smooth_tasks.h"

namespace hapton {

// A paper's value for its own system, and the value of this machine today.
struct PaperRow {
  std::string key;                    // name of the row in CSV and JSON, for example "memo.round_trip"
  std::string what;                   // description for people
  std::string unit;                   // unit of both values; empty: a plain number
  std::optional<double> paper_value;  // none: the paper claims it without a figure
  std::string quote;                  // the paper's own text or number, with its section
  std::optional<double> ours;         // none: not measured, and `how` says why
  std::string how;                    // how it was measured

  // `ours` divided by `paper_value`; none if a value is missing or `paper_value` is 0.
  std::optional<double> ratio() const;
};

struct PapersReport {
  RunConditions conditions;
  std::vector<PaperRow> rows;         // the rows of the memo, then those of the FDH paper
  std::vector<SmoothTasks> tasks;     // one for each rate of the fast task
  std::vector<HullDirections> hulls;  // one for each number of directions
  std::string tasks_mesh, hulls_mesh;

  // The row with that key. Pre: there is one. RT: no.
  PaperRow& row(std::string_view key);
  // Removes the rows that only running nodes can measure.
  void leave_out_nodes();
  // Every row has a value of ours.
  bool is_complete() const;
};

// All rows, with the papers' values filled in and ours empty.
PapersReport make_papers_report();

// Keys of the rows for which nodes must run as processes of their own.
inline constexpr std::string_view kStereoCulled = "memo.stereo_culled";
inline constexpr std::string_view kStereoUnculled = "memo.stereo_unculled";
inline constexpr std::string_view kRoundTrip = "memo.round_trip";
inline constexpr std::string_view kSystemLatency = "memo.system_latency";

// The frames per second in the line that vision_node --bench-frames prints; none if there is no such line.
std::optional<double> parse_bench_rate(std::string_view output);

std::string to_text(const PapersReport& report);
std::string to_json(const PapersReport& report);
// One line for each row of each table.
std::string to_csv(const PapersReport& report);
std::string tasks_csv(const PapersReport& report);
std::string hulls_csv(const PapersReport& report);

}  // namespace hapton
