#include "bench/measure/stopwatch.h"

#include <cmath>
#include <numeric>
#include <vector>

#include "runtime/clock.h"

namespace hapton {
namespace {

// Time for which ticks of the counter are compared with the clock; a free choice
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
  std::sort(costs.begin(), costs.end());
  // The resolution of the counter may be as long as the measured time, so the mean is more accurate than the median.
  const auto end = std::upper_bound(costs.begin(), costs.end(), 3.0 * costs[costs.size() / 2]);
  watch.cost_ns_ = std::accumulate(costs.begin(), end, 0.0) / static_cast<double>(end - costs.begin());
  watch.resolution_ns_ = costs[costs.size() / 2];
  for (std::size_t i = 1; i < costs.size(); ++i) {
    if (costs[i] > costs[i - 1]) watch.resolution_ns_ = std::min(watch.resolution_ns_, costs[i] - costs[i - 1]);
  }
  return watch;
}

}  // namespace hapton
