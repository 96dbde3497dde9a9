#pragma once

#include <filesystem>
#include <string>

#include "core/base/result.h"
#include "tools/latency/node_cpus.h"

namespace hapton {

struct LatencyRunOptions {
  static constexpr int kMeasured = -2;  // a CPU: the one with which short runs are fastest (node_cpus.h)

  double seconds = 10.0;
  double rate_hz = 1000.0;
  std::filesystem::path out = "out/latency";
  std::filesystem::path scene = "scenes/car_front.toml";
  std::string method;            // empty: the haptics node's default
  std::string realtime = "try";  // off, try or require
  int cpu = kMeasured;           // of io_node, the echo and the bare timer, unless realtime is off; -1: any
  int haptics_cpu = kMeasured;   // of haptics_node; if cpu is given, by default the same
  std::size_t echo_bytes = 0;    // of the bare echo's datagrams; 0: as many as a device sample's
  bool vision = false;           // with a vision node
  std::string hosts;             // a hub that runs already is measured instead; empty: none
  std::string key_file;          // of that hub
};

// Where the nodes run, and why, a line; empty: there was nothing to choose.
struct CpuChoice {
  NodeCpus cpus;
  std::string text;
};

// The CPUs of the options; those left open are chosen by two short runs on free loopback ports, with files in options.out while they last.
// RT: set-up only. Error: as run_latency.
Result<CpuChoice> choose_cpus(const LatencyRunOptions& options);

// The results of a run.
struct LatencyRun {
  std::string text;    // every hop, loss and jitter, the clocks, the ratio to the bare echo, the verdict
  bool holds = false;  // the verdict at the rate it was measured at
};

// Runs io_node, haptics_node, a bare echo and, on request, vision_node as child processes on free loopback ports, each writing to
// options.out/NAME.log; or watches a running hub for the given time. Leaves report.json, latency.csv, latency.png and latency.txt there.
// RT: set-up only. Error: one line: a program that cannot be started or failed (with its last output), a hub that does not reply, no force
// or, with child processes, no echo measured.
Result<LatencyRun> run_latency(const LatencyRunOptions& options);

}  // namespace hapton
