#include "bench/measure/stopwatch.h"

#include <cmath>
#include <vector>

#include "runtime/clock.h"

namespace hapton {
namespace {

constexpr std::int64_t kWindowNs = 30 * kNanosecondsPerMillisecond;

double measure_ns_per_tick() {
  const SteadyClock clock;
  const std::int64_t from_ns = clock.now_ns();
  const std::uint64_t from = Stopwatch::ticks();
  std::int64_t to_ns = from_ns;
  while (to_ns - from_ns < kWindowNs) to_ns = clock.now_ns();
  return static_cast<double>(to_ns - from_ns) / static_cast<double>(Stopwatch::ticks() - from);
}

}  // namespace

Stopwatch Stopwatch::calibrate() {
  Stopwatch watch;
  const double first = measure_ns_per_tick();
  watch.ns_per_tick_ = measure_ns_per_tick();
  watch.drift_ = std::fabs(watch.ns_per_tick_ / first - 1.0);
  std::vector<double> costs(10001);
  for (double& cost : costs) {
    const std::uint64_t from = ticks();
    cost = watch.ns_between(from, ticks());
  }
  std::nth_element(costs.begin(), costs.begin() + 5000, costs.end());
  watch.cost_ns_ = costs[5000];
  return watch;
}

}  // namespace hapton
