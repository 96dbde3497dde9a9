#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "tools/soak/process_stats.h"

namespace hapton {

// A sample of a system under soak. Counts and drift are since the sampling began, rates and latencies since the previous sample.
struct SoakSample {
  double seconds = 0.0;
  double samples_hz = 0.0;
  double forces_hz = 0.0;
  double contacts_hz = 0.0;
  double drawn_hz = 0.0;
  std::int64_t lost = 0;  // forces that never came; this and the next three are counts
  std::int64_t late = 0;
  std::int64_t superseded = 0;
  std::int64_t missed_cycles = 0;
  double round_trip_p50_us = 0.0;  // 0: no force in this time
  double round_trip_p99_us = 0.0;
  double round_trip_max_us = 0.0;
  double drift_ms = 0.0;  // servo cycles, run or missed, times their period, minus the time on the steady clock
  std::vector<ProcessStats> processes;
};

// The run and its intended duration.
struct SoakRun {
  double seconds = 0.0;
  double rate_hz = 0.0;
  std::vector<std::string> processes;  // names, in the order of SoakSample::processes
  std::vector<SoakSample> samples;
  std::string end_reason;  // the error of the process that ended, or what else cut the run short; empty: nothing did
};

// How much a quantity rose from the beginning of a series to its end: by Theil and Sen's trend (the median of all slopes; H. Theil,
// Indagationes Mathematicae 12, 1950; P. K. Sen, JASA 63, 1968) or from the median of the first third to that of the last, whichever is
// larger in magnitude. The first detects slow growth, the second a single step; an outlier changes neither. 0 for fewer than three values.
// Pre: as many times as values; times rise. RT: no.
double find_rise(std::span<const double> times, std::span<const double> values);

// One quantity that was checked.
struct SoakFinding {
  std::string what;     // memory, descriptors, threads, lost, rate, drift, run
  std::string process;  // empty: the system as a whole
  double value = 0.0;
  double limit = 0.0;
  bool is_flat = false;
  std::string text;  // the result, in words
};

struct SoakVerdict {
  bool is_flat = false;
  std::vector<SoakFinding> findings;
};

// Warm-up is the first tenth of the time, or 30 s if that is more, but at most half the time: its samples count only for lost forces. A run
// passes if, after it, resident memory of each process rises by no more than 1 % plus 1 MiB, its descriptors and threads do not change, no
// force is lost, the median sample has 99 % of the rate in samples and forces, servo cycles drift from the clock by at most 100 ms plus 100
// ppm, no process ends, and nobody stops the run early. Late and missed cycles are reported but do not count: they depend on the machine
// as much as on Hapton (`hapton latency run` evaluates them). With fewer than 5 samples after warm-up it fails.
SoakVerdict evaluate_soak(const SoakRun& run);

// soak.json and the closing line.
nlohmann::ordered_json to_json(const SoakRun& run, const SoakVerdict& verdict);
std::string to_text(const SoakRun& run, const SoakVerdict& verdict);

}  // namespace hapton
