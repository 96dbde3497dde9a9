#pragma once

#include <filesystem>
#include <string>

#include "core/base/result.h"

namespace hapton {

struct SoakOptions {
  double seconds = 3600.0;
  double every_s = 0.0;  // interval between two samples of the nodes; 0: a 120th of `seconds`, at least 2 s
  double rate_hz = 1000.0;
  bool vision = false;  // also run a vision node
  std::filesystem::path out = "out/soak";
  std::filesystem::path scene = "scenes/car_front.toml";
  std::string key_file;          // key file of the nodes; empty: the default key of this user
  std::string realtime = "try";  // off, try or require
  int cpu = -1;                  // pins io_node and haptics_node to this CPU; -1: any CPU
};

// The interval between two samples, s: every_s, or its default.
double sample_interval_s(const SoakOptions& options);

struct SoakEnd {
  std::string text;      // the verdict in one line, and where the files are
  bool is_flat = false;  // the run was complete, and no quantity drifted
};

// Runs io_node, haptics_node and, on request, vision_node as child processes on a free loopback port, samples them regularly and prints its
// progress. Writes soak.csv (row by row), soak.json, soak.png and the nodes' logs and reports to options.out. Ctrl-C ends it early, and the
// verdict is then not flat. RT: no. Error, one line: a program cannot be started or failed before the first sample, or the folder cannot be
// written to.
Result<SoakEnd> run_soak(const SoakOptions& options);

}  // namespace hapton
