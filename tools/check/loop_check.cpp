#include "tools/check/loop_check.h"

#include <fmt/format.h>

#include <cmath>

#include "loop/recommendation.h"

namespace hapton {
namespace {

// Whole N/m, rounded down: a value that is asked for must not be above the limit.
std::string at_most(double stiffness_n_per_m) { return fmt::format("{:.0f}", std::floor(stiffness_n_per_m)); }

}  // namespace

HeldStiffness find_held_stiffness(std::span<const NamedLoop> loops, double rate_hz, double delay_s) {
  HeldStiffness held;
  for (const NamedLoop& loop : loops) {
    const Recommendation advice = recommend_stiffness(loop.device_model, loop.limits, loop.hand_model, rate_hz, delay_s);
    const double safe_n_per_m = advice.stable_n_per_m / kGainMargin;
    if (held.by_loop == nullptr || safe_n_per_m < held.safe_n_per_m) {
      held.by_loop = &loop;
      held.safe_n_per_m = safe_n_per_m;
    }
    if (advice.device_n_per_m > 0.0 && (held.by_device == nullptr || advice.device_n_per_m < held.device_n_per_m)) {
      held.by_device = &loop;
      held.device_n_per_m = advice.device_n_per_m;
    }
  }
  return held;
}

CheckFindings check_stiffness(const SceneObject& object, const HeldStiffness& held, double rate_hz, double delay_s) {
  CheckFindings findings;
  const double stiffness_n_per_m = object.material.stiffness_n_per_m;
  if (held.by_device != nullptr && stiffness_n_per_m > held.device_n_per_m) {
    findings.push_back({SceneFault::stiffer_than_device, object.name, std::nullopt,
                        fmt::format("{:.6g} N/m, but the maker of {} gives {:.6g} N/m at most", stiffness_n_per_m, held.by_device->device,
                                    held.device_n_per_m),
                        fmt::format("set its stiffness_n_per_m to {} or less", at_most(held.device_n_per_m))});
  }
  if (held.by_loop != nullptr && stiffness_n_per_m > held.safe_n_per_m) {
    findings.push_back(
        {SceneFault::stiffer_than_loop, object.name, std::nullopt,
         fmt::format("{:.6g} N/m, but {} in hand {} at {:g} Hz with forces after {:.3g} ms holds {} N/m safely", stiffness_n_per_m,
                     held.by_loop->device, held.by_loop->hand, rate_hz, 1e3 * delay_s, at_most(held.safe_n_per_m)),
         fmt::format("set its stiffness_n_per_m to {} or less, or shorten the delay (hapton loop recommend)", at_most(held.safe_n_per_m))});
  }
  return findings;
}

}  // namespace hapton
