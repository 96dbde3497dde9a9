#pragma once

#include <filesystem>
#include <string>

#include "core/base/result.h"
#include "tools/latency/node_cpus.h"

namespace hapton {

struct LatencyRunOptions {
  static constexpr int kChosenByRuns = -2;  // for a CPU: chosen by short runs (choose_cpus)

  double seconds = 10.0;
  double rate_hz = 1000.0;
  std::filesystem::path out = "out/latency";
  std::filesystem::path scene = "scenes/car_front.toml";
  std::string method;               // empty: the haptics node's default
  std::string realtime = "try";     // off, try or require
  int cpu = kChosenByRuns;          // the CPU of io_node, the echo and the bare timer, unless realtime is off; -1: any
  int haptics_cpu = kChosenByRuns;  // the CPU of haptics_node; if only one of the two is given, it is for both
  std::size_t echo_bytes = 0;       // size of the bare echo's datagrams; 0: that of a device sample's
  bool vision = false;              // also starts a vision node
  std::string hosts;                // address of a running hub that is measured instead; empty: none
  std::string key_file;             // key file of that hub
};

// The CPUs of the nodes, and the reason for the choice, one line; empty: there was no choice.
struct CpuChoice {
  NodeCpus cpus;
  std::string text;
};

// The CPUs of the options. If none is given, realtime is not off and there are two CPUs, two short runs on free loopback ports decide; they
// use the folder options.out/trial and remove it if they succeed. RT: set-up only. Error: that of run_latency.
Result<CpuChoice> choose_cpus(const LatencyRunOptions& options);

// The results of a run.
struct LatencyRun {
  std::string text;    // every hop, loss and jitter, the clocks, the ratio to the bare echo, the verdict
  bool holds = false;  // LatencyVerdict::holds
};

// Runs io_node, haptics_node, a bare echo and, on request, vision_node as child processes on free loopback ports, each writing to
// options.out/NAME.log; or watches a running hub for the given time. Writes report.json, latency.csv, latency.txt and, with gnuplot,
// latency.png there. RT: set-up only. Error, one line: a program cannot be started or failed (with its last output), the hub does not
// reply, no force was measured or, with child processes, no echo.
Result<LatencyRun> run_latency(const LatencyRunOptions& options);

}  // namespace hapton
