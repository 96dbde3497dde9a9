#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bench/measure/run_conditions.h"
#include "bench/papers/hull_directions.h"
#include "bench/papers/smooth_tasks.h"

namespace hapton {

// A paper's number for its own system, and the number of this machine today.
struct PaperRow {
  std::string key;               // "memo.round_trip": its name in CSV and JSON
  std::string what;              // for people
  std::string unit;              // of both values; empty: a plain number
  std::optional<double> theirs;  // none: the paper claims it without a figure
  std::string said;              // the paper's own text or number, with its section
  std::optional<double> ours;    // none: not measured, and `how` says why
  std::string how;               // how it was measured

  // Ours over theirs, where both are there and theirs is not 0.
  std::optional<double> ratio() const;
};

struct PapersReport {
  RunConditions conditions;
  std::vector<PaperRow> rows;         // the memo's, then the FDH paper's
  std::vector<SmoothTasks> tasks;     // by rate
  std::vector<HullDirections> hulls;  // by directions
  std::string tasks_mesh, hulls_mesh;

  // The row of that key; it is there. RT: no.
  PaperRow& row(std::string_view key);
  // Takes out the rows that only running nodes can give.
  void leave_out_nodes();
  // Every row has a value of ours.
  bool is_complete() const;
};

// All rows, theirs filled in and ours not.
PapersReport make_papers_report();

// Keys of the rows that need nodes of their own process.
inline constexpr std::string_view kStereoCulled = "memo.stereo_culled";
inline constexpr std::string_view kStereoUnculled = "memo.stereo_unculled";
inline constexpr std::string_view kRoundTrip = "memo.round_trip";
inline constexpr std::string_view kSystemLatency = "memo.system_latency";

// From vision_node --bench-frames: frames per second in the line it prints; empty if there is no such line.
std::optional<double> parse_bench_rate(std::string_view output);

std::string to_text(const PapersReport& report);
std::string to_json(const PapersReport& report);
// One line a row of each table.
std::string to_csv(const PapersReport& report);
std::string tasks_csv(const PapersReport& report);
std::string hulls_csv(const PapersReport& report);

}  // namespace hapton
