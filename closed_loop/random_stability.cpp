#include "closed_loop/random_stability.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "closed_loop/largest_value.h"
#include "closed_loop/loop_simulation.h"

namespace hapton {
namespace {

constexpr double kStartM = 1e-3;         // any distance will do, because the loop is linear
constexpr double kNegligibleM = 1e-200;  // m; a motion that has died out to this is not followed farther
constexpr double kInfiniteValue = std::numeric_limits<double>::infinity();

constexpr double kStride = 1.25;  // factor of each step of the search, upwards or downwards
constexpr double kFine = 2e-3;    // relative width at which the search ends

// The largest distance in these rows from where the hand wants to be.
double largest_position(const std::vector<LoopRow>& rows) {
  double most = 0.0;
  for (const LoopRow& row : rows) most = std::max(most, std::fabs(row.p_WD.x()));
  return most;
}

// The largest motion in these rows from one sample to the next: for a device that nobody holds, which need not return.
double largest_motion(const std::vector<LoopRow>& rows) {
  double most = 0.0;
  for (std::size_t i = 1; i < rows.size(); ++i) most = std::max(most, std::fabs(rows[i].p_WD.x() - rows[i - 1].p_WD.x()));
  return most;
}

template <class Size>
double growth_per_s(const RandomLoop& loop, const WallLaw::Wall& gains, const HandPath& path, Size measure_size) {
  DeviceModel device = loop.device;
  device.friction_n = 0.0;
  WallLaw wall(gains);
  ForceChain chain(wall, {.to_law = loop.to_law, .from_law = loop.from_law, .seed = loop.seed});
  LoopSimulation simulation(
      chain, {.device = device, .hand = loop.hand, .period_ns = loop.period_ns, .path = path, .start_m = {kStartM, 0.0, 0.0}});
  const auto third_ns = static_cast<std::int64_t>(1e9 * loop.seconds / 3.0);
  const auto largest = [&](std::int64_t until_ns) {
    std::vector<LoopRow> rows;
    return simulation.run_until(until_ns, &rows) ? measure_size(rows) : kInfiniteValue;
  };
  if (std::isinf(largest(third_ns))) return kInfiniteValue;
  const double before = largest(2 * third_ns);
  const double after = largest(3 * third_ns);
  if (after < kNegligibleM) return -kInfiniteValue;
  return std::log(after / before) / (1e-9 * static_cast<double>(third_ns));
}

// Searches upwards from `start`, or downwards if `start` is unstable already. 0: unstable however small the value.
template <class IsStable>
double find_limit(double start, IsStable is_stable) {
  // Shares of the start: a limit below the first counts as 0, one above the second as infinite.
  constexpr double kMinShare = 1e-6;
  constexpr double kMaxShare = 1e9;
  double low = start;
  double high = start;
  if (is_stable(low)) {
    for (high *= kStride; is_stable(high); high *= kStride) {
      low = high;
      if (low > kMaxShare * start) return kInfiniteValue;
    }
  } else {
    for (low /= kStride; !is_stable(low); low /= kStride) {
      high = low;
      if (low < kMinShare * start) return 0.0;
    }
  }
  return bisect(low, high, kFine, is_stable);
}

// The force is the position that was sampled.
class EchoLaw final : public ForceLaw {
 public:
  Vec3 step(const Vec3& p_WD, double /*dt_s*/) noexcept override { return p_WD; }
  void reset(const Vec3& /*p_WD*/) noexcept override {}
};

}  // namespace

double measure_growth_per_s(const RandomLoop& loop, double stiffness_n_per_m) {
  return growth_per_s(loop, {.stiffness_n_per_m = stiffness_n_per_m, .damping_ns_per_m = loop.wall_damping_ns_per_m, .two_sided = true}, {},
                      largest_position);
}

double find_stable_stiffness_by_simulation(const RandomLoop& loop, double start_n_per_m) {
  return find_limit(start_n_per_m, [&](double stiffness) { return measure_growth_per_s(loop, stiffness) < 0.0; });
}

double find_stable_damping_by_simulation(const RandomLoop& loop, double start_ns_per_m) {
  // A push starts the motion, because a device that nobody holds would not move.
  constexpr std::int64_t kPushNs = 10'000'000;
  const HandPath pushed({{.time_ns = 0, .push_n = {1.0, 0.0, 0.0}}, {.time_ns = kPushNs}});
  return find_limit(start_ns_per_m, [&](double damping) {
    return growth_per_s(loop, {.stiffness_n_per_m = 0.0, .damping_ns_per_m = damping, .two_sided = true}, pushed, largest_motion) < 0.0;
  });
}

double measure_mean_delay_s(const RandomLoop& loop) {
  EchoLaw law;
  ForceChain chain(law, {.to_law = loop.to_law, .from_law = loop.from_law, .seed = loop.seed});
  const auto end_ns = static_cast<std::int64_t>(1e9 * loop.seconds);
  double sum_s_ns = 0.0;
  double counted_ns = 0.0;
  for (std::int64_t tick_ns = 0; tick_ns < end_ns; tick_ns += loop.period_ns) {
    // The position is the time, so the force on the motors is the time of its sample.
    chain.sample({1e-9 * static_cast<double>(tick_ns), 0.0, 0.0}, tick_ns);
    // Only whole periods count, from the first one that begins with a force.
    const bool counts = chain.counters().replies > 0;
    for (std::int64_t now_ns = tick_ns; now_ns < tick_ns + loop.period_ns;) {
      const std::int64_t until_ns = std::min(tick_ns + loop.period_ns, chain.next_ns().value_or(std::numeric_limits<std::int64_t>::max()));
      if (counts) {
        const auto passed_ns = static_cast<double>(until_ns - now_ns);
        sum_s_ns += passed_ns * (0.5e-9 * static_cast<double>(now_ns + until_ns) - chain.force_n().x());
        counted_ns += passed_ns;
      }
      now_ns = until_ns;
      chain.receive(now_ns);
    }
  }
  const double half_period_s = 0.5e-9 * static_cast<double>(loop.period_ns);
  return counted_ns > 0.0 ? std::max(0.0, sum_s_ns / counted_ns - half_period_s) : kInfiniteValue;
}

}  // namespace hapton
