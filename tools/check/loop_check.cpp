#include "tools/check/loop_check.h"

#include <fmt/format.h>

#include <cmath>
#include <string>
#include <variant>

#include "core/force/stiffest.h"
#include "loop/recommendation.h"
#include "loop/stability.h"

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

namespace {

// what_to_set: "its stiffness_n_per_m".
CheckFindings compare_stiffness(const std::string& name, double stiffness_n_per_m, const std::string& what_to_set,
                                const HeldStiffness& held, double rate_hz, double delay_s) {
  CheckFindings findings;
  if (held.by_device != nullptr && stiffness_n_per_m > held.device_n_per_m) {
    findings.push_back({SceneFault::stiffer_than_device, name, std::nullopt,
                        fmt::format("{:.6g} N/m, but the stiffness limit of {} is {:.6g} N/m", stiffness_n_per_m, held.by_device->device,
                                    held.device_n_per_m),
                        fmt::format("set {} to {} or less", what_to_set, at_most(held.device_n_per_m))});
  }
  if (held.by_loop != nullptr && stiffness_n_per_m > held.safe_n_per_m) {
    findings.push_back(
        {SceneFault::stiffer_than_loop, name, std::nullopt,
         fmt::format("{:.6g} N/m, but {} in hand {} at {:g} Hz with forces after {:.3g} ms is safe only up to {} N/m", stiffness_n_per_m,
                     held.by_loop->device, held.by_loop->hand, rate_hz, 1e3 * delay_s, at_most(held.safe_n_per_m)),
         fmt::format("set {} to {} or less, or shorten the delay (hapton loop recommend)", what_to_set, at_most(held.safe_n_per_m))});
  }
  return findings;
}

// The keys that make it as stiff as it is.
std::string stiff_keys_of(const SurfaceEffects& effects) {
  if (effects.layers.is_on()) return "the stiffness_n_per_m of its layers";
  if (effects.progressive.is_on()) return "its stiffness_n_per_m, with what progressive_n_per_m2 adds at 10 N,";
  return effects.snap.is_on() ? "its stiffness_n_per_m and snap_stiffness_n_per_m" : "its stiffness_n_per_m";
}

}  // namespace

CheckFindings check_stiffness(const SceneObject& object, const HeldStiffness& held, double rate_hz, double delay_s) {
  return compare_stiffness(object.name, stiffest_of(object.material, object.effects), stiff_keys_of(object.effects), held, rate_hz,
                           delay_s);
}

CheckFindings check_stiffness(const SceneEffect& effect, const HeldStiffness& held, double rate_hz, double delay_s) {
  const bool is_spring = std::holds_alternative<SpringEffect>(effect.effect);
  return compare_stiffness(fmt::format("effect {}", effect.name), stiffest_of(effect.effect),
                           is_spring ? "its stiffness_n_per_m" : "4 max_force_n / range_m", held, rate_hz, delay_s);
}

CheckFindings check_mass(const SceneEffect& effect, std::span<const NamedLoop> loops, double rate_hz, double delay_s) {
  const auto* mass = std::get_if<MassEffect>(&effect.effect);
  if (mass == nullptr) return {};
  const NamedLoop* least = nullptr;
  double safe_kg = mass->mass_kg;
  for (const NamedLoop& loop : loops) {
    const SampledPlant plant(make_axis_plant(loop.device_model, loop.hand_model), 1.0 / rate_hz, delay_s);
    const double held_kg = find_stable_mass(plant, mass->filter_s).value / kGainMargin;
    if (held_kg >= safe_kg) continue;
    safe_kg = held_kg;
    least = &loop;
  }
  if (least == nullptr) return {};
  return {{SceneFault::heavier_than_loop, fmt::format("effect {}", effect.name), std::nullopt,
           fmt::format("a virtual mass of {:.4g} kg, but {} in hand {} at {:g} Hz with forces after {:.3g} ms is safe only up to {:.3g} kg",
                       mass->mass_kg, least->device, least->hand, rate_hz, 1e3 * delay_s, safe_kg),
           "set its mass_kg to that or less, or its filter_s to more (hapton loop zwidth --mass-filter)"}};
}

}  // namespace hapton
