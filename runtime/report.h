#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "runtime/latency_histogram.h"

namespace hapton {

// The value of "schema" in report.json; a reader rejects any other. New fields may be added within a version.
constexpr const char* kReportSchema = "hapton.report/4";

// The machine on which a measurement was made.
struct MachineInfo {
  std::string host;
  std::string cpu;
  int cpu_count = 0;
  std::string kernel;
  std::string compiler;
  std::string build;  // "release AVX2 FMA": kind of build, instruction sets
};

// RT: no.
MachineInfo read_machine_info();

// The latencies between two points of the system.
struct LatencyHop {
  std::string name;  // "force_round_trip": lower case with underscores, because it becomes a key
  LatencyHistogram histogram;
};

// A node that has joined, and the datagrams that came from it and went to it.
struct ReportNode {
  std::string role;
  std::string address;
  double seconds = 0.0;  // since it joined
  std::int64_t received = 0;
  std::int64_t lost = 0;
  std::int64_t reordered = 0;
  std::int64_t duplicate = 0;
  std::int64_t sent = 0;
  std::int64_t send_failures = 0;
};

// The report of a run. One format for nodes, tools and tests.
struct LatencyReport {
  std::string program;
  MachineInfo machine;
  double seconds = 0.0;  // duration of the measurement
  std::map<std::string, double> rates_hz;
  std::map<std::string, std::int64_t> counters;
  std::map<std::string, double> ratios;      // "round_trip_over_echo_p50"
  std::map<std::string, std::string> notes;  // seed, scene, method, real-time state ...
  std::vector<ReportNode> nodes;
  std::vector<LatencyHop> hops;
};

// JSON, schema kReportSchema: program, machine, seconds, rates_hz, counters, ratios, notes, nodes, and per hop n and p50, p90, p99, p99_9,
// max, mean in us.
std::string to_json(const LatencyReport& report);

// Rows hop,lower_ns,upper_ns,count: each row is a bucket [lower, upper) of a hop.
std::string to_csv(const LatencyReport& report);

// Writes report.json and latency.csv into `folder`, which is created if necessary. Each file appears complete or not at all: it is written
// to a temporary file and renamed. RT: no. Error: one line naming the file and the reason.
Result<void> write_report(const LatencyReport& report, const std::filesystem::path& folder);

}  // namespace hapton
