#pragma once

#include <filesystem>
#include <string>

#include "core/base/result.h"

namespace hapton {

struct LatencyRunOptions {
  double seconds = 10.0;
  double rate_hz = 1000.0;
  std::filesystem::path out = "out/latency";
  std::filesystem::path scene = "scenes/car_front.toml";
  std::string method;            // empty: the haptics node's default
  std::string realtime = "try";  // off, try or require
  int cpu = -1;                  // all three stay on this CPU, unless realtime is off; -1: any
};

// Runs io_node, haptics_node and a bare echo as processes of their own on free loopback ports, each writing to options.out/NAME.log, and
// leaves report.json, latency.csv and latency.png there. Gives the report as text: every hop, and the force round trip against the bare
// echo of the same run.
// RT: set-up only. Error: one line: a program that cannot be started or failed (with its last words), no force or no echo measured.
Result<std::string> run_latency(const LatencyRunOptions& options);

}  // namespace hapton
