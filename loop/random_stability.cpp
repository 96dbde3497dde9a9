#include "loop/random_stability.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "loop/largest_value.h"
#include "loop/loop_simulation.h"

namespace hapton {
namespace {

constexpr double kStartM = 1e-3;
constexpr double kTiny = 1e-200;  // m; what has died out so far is not followed farther

// Amplitude over a while.
double largest(LoopSimulation& simulation, std::int64_t until_ns) {
  std::vector<LoopRow> rows;
  if (!simulation.run_until(until_ns, &rows)) return std::numeric_limits<double>::infinity();
  double most = 0.0;
  for (const LoopRow& row : rows) most = std::max(most, std::fabs(row.p_WD.x()));
  return most;
}

}  // namespace

double measure_growth_per_s(const RandomLoop& loop, double stiffness_n_per_m) {
  DeviceModel device = loop.device;
  device.friction_n = 0.0;
  WallLaw wall({.stiffness_n_per_m = stiffness_n_per_m, .damping_ns_per_m = loop.wall_damping_ns_per_m, .two_sided = true});
  ForceChain chain(wall, {.there = loop.there, .back = loop.back, .seed = loop.seed});
  LoopSimulation simulation(chain, {.device = device, .hand = loop.hand, .period_ns = loop.period_ns, .start_m = {kStartM, 0.0, 0.0}});
  const auto third_ns = static_cast<std::int64_t>(1e9 * loop.seconds / 3.0);
  if (std::isinf(largest(simulation, third_ns))) return std::numeric_limits<double>::infinity();
  const double before = largest(simulation, 2 * third_ns);
  const double after = largest(simulation, 3 * third_ns);
  if (after < kTiny) return -std::numeric_limits<double>::infinity();
  return std::log(after / before) / (1e-9 * static_cast<double>(third_ns));
}

double find_stable_stiffness_by_simulation(const RandomLoop& loop, double start_n_per_m) {
  constexpr double kStride = 1.25;
  constexpr double kFine = 2e-3;
  constexpr double kLeastShare = 1e-6;
  const auto is_stable = [&](double stiffness) { return measure_growth_per_s(loop, stiffness) < 0.0; };
  double low = start_n_per_m;
  double high = start_n_per_m;
  if (is_stable(low)) {
    for (high *= kStride; is_stable(high); high *= kStride) low = high;
  } else {
    for (low /= kStride; !is_stable(low); low /= kStride) {
      high = low;
      if (low < kLeastShare * start_n_per_m) return 0.0;
    }
  }
  return bisect(low, high, kFine, is_stable);
}

}  // namespace hapton
