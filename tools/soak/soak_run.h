#pragma once

#include <filesystem>
#include <string>

#include "core/base/result.h"

namespace hapton {

struct SoakOptions {
  double seconds = 3600.0;
  double every_s = 0.0;  // between two looks; 0: a 120th of the time, at least 2 s
  double rate_hz = 1000.0;
  bool vision = false;  // with a vision node
  std::filesystem::path out = "out/soak";
  std::filesystem::path scene = "scenes/car_front.toml";
  std::string key_file;          // of the nodes; empty: the one that this user's nodes share on a machine
  std::string realtime = "try";  // off, try or require
  int cpu = -1;                  // io_node and haptics_node stay on this CPU; -1: any
};

// How long between two looks.
double look_interval_s(const SoakOptions& options);

struct SoakEnd {
  std::string text;  // the verdict in a line, and where the files are
  bool flat = false;
};

// Runs io_node, haptics_node and, on request, vision_node as child processes on a free loopback port, samples them regularly and prints its
// progress. Leaves soak.csv (written row by row), soak.json, soak.png and the nodes' logs and reports in options.out. Ctrl-C ends it early,
// and the verdict is then not flat. RT: set-up only. Error: one line: a program that cannot be started or failed before the first sample, a
// folder that cannot be written to.
Result<SoakEnd> run_soak(const SoakOptions& options);

}  // namespace hapton
