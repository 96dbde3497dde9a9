#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "bench/measure/cpu_pin.h"
#include "bench/measure/stopwatch.h"

namespace hapton {

// A summary of the times of the steps of a run. Nanoseconds; quantiles by nearest rank; all zero when nothing was timed.
struct TimeSpread {
  std::size_t count = 0;
  double p50_ns = 0.0, p90_ns = 0.0, p99_ns = 0.0, p99_9_ns = 0.0;
  double worst_ns = 0.0;  // the slowest step
};

TimeSpread spread_of_times(std::vector<double> ns);

// The least time of each step over all repetitions: it excludes the load of other programs and keeps the step's own cost. The largest of
// these times is that of the worst step.
class LeastTimes {
 public:
  explicit LeastTimes(std::size_t steps) : ns_(steps, std::numeric_limits<double>::infinity()) {}

  void add(std::size_t step, double ns) {
    if (ns < ns_[step]) ns_[step] = ns;
  }
  const std::vector<double>& ns() const { return ns_; }
  // The least times of only those steps for which keep[i] is not 0. Pre: keep has one element for each step.
  std::vector<double> only(const std::vector<std::uint8_t>& keep) const;

 private:
  std::vector<double> ns_;
};

struct TimingBudget {
  int repetitions = 5;    // largest number of repetitions
  double seconds = 10.0;  // a repetition that would exceed this time does not begin; the first one always runs
};

struct TimedSteps {
  LeastTimes least{0};
  int repetitions = 0;
  double seconds = 0.0;
  double mean_ns = 0.0;  // mean step, the least of up to two passes without reading the clock in between; 0: no time was left for them
};

// Runs step(i) for i = 0 .. steps - 1, again and again, on one CPU, and takes the least time of each. before(i) and after(i) are not timed,
// but in the passes for the mean the time of before(i) counts and after(i) does not run.
template <class Before, class Step, class After>
TimedSteps time_steps(const Stopwatch& watch, const TimingBudget& budget, std::size_t steps, Before&& before, Step&& step, After&& after) {
  TimedSteps timed{.least = LeastTimes(steps), .repetitions = 0, .seconds = 0.0, .mean_ns = 0.0};
  const CpuPin pin;
  double last_s = 0.0;
  while (timed.repetitions == 0 || (timed.repetitions < budget.repetitions && timed.seconds + last_s <= budget.seconds)) {
    const std::uint64_t start = Stopwatch::ticks();
    for (std::size_t i = 0; i < steps; ++i) {
      before(i);
      const std::uint64_t from = Stopwatch::ticks();
      step(i);
      timed.least.add(i, watch.ns_between(from, Stopwatch::ticks()));
      after(i);
    }
    last_s = 1e-9 * watch.ns_between(start, Stopwatch::ticks());
    timed.seconds += last_s;
    ++timed.repetitions;
  }
  for (int pass = 0; pass < 2 && steps > 0 && timed.seconds + last_s <= budget.seconds; ++pass) {
    const std::uint64_t start = Stopwatch::ticks();
    for (std::size_t i = 0; i < steps; ++i) {
      before(i);
      step(i);
    }
    const double mean_ns = watch.ns_between(start, Stopwatch::ticks()) / static_cast<double>(steps);
    timed.mean_ns = pass == 0 ? mean_ns : std::min(timed.mean_ns, mean_ns);
  }
  return timed;
}

}  // namespace hapton
