#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "tools/soak/process_stats.h"

namespace hapton {

// A look at a system under soak. Counts and drift are of the time since the first look, rates and latencies of that since the look before.
struct SoakLook {
  double seconds = 0.0;
  double samples_hz = 0.0;
  double forces_hz = 0.0;
  double contacts_hz = 0.0;
  double drawn_hz = 0.0;
  std::int64_t lost = 0;  // forces that never came
  std::int64_t late = 0;
  std::int64_t superseded = 0;
  std::int64_t missed_cycles = 0;
  double round_trip_p50_us = 0.0;  // 0: no force in this time
  double round_trip_p99_us = 0.0;
  double round_trip_max_us = 0.0;
  double drift_ms = 0.0;  // the servo's ticks (cycles run and missed, by their period) ahead of the steady clock
  std::vector<ProcessStats> processes;
};

// What was run and how long it was meant to be.
struct SoakRun {
  double seconds = 0.0;
  double rate_hz = 0.0;
  std::vector<std::string> processes;  // names, in the order of SoakLook::processes
  std::vector<SoakLook> looks;
  std::string ended;  // the process that ended, or what else cut the run short; empty: nothing did
};

// How far a figure rose from the beginning of a series to its end: by Theil and Sen's trend (the median of all slopes; H. Theil,
// Indagationes Mathematicae 12, 1950; P. K. Sen, JASA 63, 1968) or from the median of the first third to that of the last, whichever is
// more. The first sees what creeps, the second what jumps once, neither heeds a single look. Pre: as many times as values, rising. RT: no.
double find_rise(std::span<const double> times, std::span<const double> values);

// One thing that was looked at.
struct SoakFinding {
  std::string what;     // memory, descriptors, threads, lost, rate, drift, run
  std::string process;  // empty: the system as a whole
  double value = 0.0;
  double limit = 0.0;
  bool flat = false;
  std::string text;  // what was found, in words
};

struct SoakVerdict {
  bool flat = false;
  std::vector<SoakFinding> findings;
};

// The rule. Looks in the first tenth of the time, or the first 30 s where that is more (but at most half), are warm-up and count only for
// lost forces. After them, of each process, resident memory rises by no more than 1 % and 1 MiB, descriptors and threads by none (nor
// fall); no force is lost; the median look has 99 % of the rate in samples and forces; ticks keep to the clock within 100 ms and 100 ppm;
// no process ends and nobody stops the run before its time. What is late or missed is told, not judged: that is the machine's as much as
// ours (`hapton latency run` judges it).
SoakVerdict judge_soak(const SoakRun& run);

// soak.json and the closing line.
nlohmann::ordered_json to_json(const SoakRun& run, const SoakVerdict& verdict);
std::string to_text(const SoakRun& run, const SoakVerdict& verdict);

}  // namespace hapton
