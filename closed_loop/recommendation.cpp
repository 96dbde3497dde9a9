#include "closed_loop/recommendation.h"

#include <algorithm>
#include <limits>

#include "closed_loop/zwidth.h"

namespace hapton {

namespace {

// This many shorter delays are tried, too (a free choice): latency varies, and a loop that is stable with a long delay can be unstable with
// a shorter one.
constexpr int kDelays = 32;
constexpr double kNoLimit = std::numeric_limits<double>::infinity();

}  // namespace

Recommendation recommend_stiffness(const DeviceModel& device, const DeviceLimits& limits, const HandModel& hand, double rate_hz,
                                   double delay_s) {
  Recommendation advice{
      .stable_n_per_m = kNoLimit, .passive_n_per_m = kNoLimit, .damping_ns_per_m = kNoLimit, .viscosity_ns_per_m = kNoLimit};
  for (int i = 0; i <= kDelays; ++i) {
    const double share = static_cast<double>(i) / kDelays;
    const ZWidth width = find_zwidth({.device = device, .hand = hand, .rate_hz = rate_hz, .delay_s = share * delay_s});
    advice.stable_n_per_m = std::min(advice.stable_n_per_m, width.stiffness.value);
    advice.passive_n_per_m = std::min(advice.passive_n_per_m, width.passive.least_n_per_m());
    advice.damping_ns_per_m = std::min(advice.damping_ns_per_m, width.damping_ns_per_m.value / kGainMargin);
    advice.viscosity_ns_per_m = std::min(advice.viscosity_ns_per_m, width.viscosity_ns_per_m.value / kGainMargin);
  }
  advice.device_n_per_m = limits.max_stiffness_n_per_m;
  advice.stiffness_n_per_m = advice.stable_n_per_m / kGainMargin;
  advice.is_limited_by_device = advice.device_n_per_m > 0.0 && advice.device_n_per_m < advice.stiffness_n_per_m;
  if (advice.is_limited_by_device) advice.stiffness_n_per_m = advice.device_n_per_m;
  return advice;
}

}  // namespace hapton
