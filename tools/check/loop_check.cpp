#include "tools/check/loop_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <variant>

#include "closed_loop/recommendation.h"
#include "closed_loop/stability.h"
#include "closed_loop/turning_axis.h"
#include "core/base/rounded_down.h"
#include "scene/scene_key.h"

namespace hapton {
namespace {

// Whole N/m, rounded down: a value that the report recommends must not be above the limit.
std::string text_rounded_down(double stiffness_n_per_m) { return fmt::format("{:.0f}", std::floor(stiffness_n_per_m)); }

std::string shown_name(const SceneEffect& effect) { return fmt::format("effect {}", effect.name); }

// For example "model-a in hand light at 1000 Hz with forces after 0.5 ms".
std::string describe_loop(const NamedLoop& loop, double rate_hz, double delay_s) {
  return fmt::format("{} at {:g} Hz with forces after {:.3g} ms", loop.title(), rate_hz, 1e3 * delay_s);
}

// Keeps the least value so far, and the loop that it belongs to.
void keep_least(const NamedLoop& loop, double value, const NamedLoop*& by, double& least) {
  if (by != nullptr && value >= least) return;
  by = &loop;
  least = value;
}

}  // namespace

SafeGains find_safe_gains(std::span<const NamedLoop> loops, double rate_hz, double delay_s) {
  SafeGains gains;
  gains.pressed_n = 0.0;
  for (const NamedLoop& loop : loops) {
    const double most_n = loop.limits.max_force_n;
    gains.pressed_n = std::max(gains.pressed_n, most_n > 0.0 ? std::min(most_n, kMaxPressedN) : kMaxPressedN);
    const Recommendation advice = recommend_stiffness(loop.device_model, loop.limits, loop.hand_model, rate_hz, delay_s);
    keep_least(loop, advice.stable_n_per_m / kGainMargin, gains.by_loop, gains.safe_n_per_m);
    keep_least(loop, advice.damping_ns_per_m, gains.by_damping, gains.damping_ns_per_m);
    keep_least(loop, advice.viscosity_ns_per_m, gains.by_viscosity, gains.viscosity_ns_per_m);
    if (advice.device_n_per_m > 0.0) keep_least(loop, advice.device_n_per_m, gains.by_device, gains.device_n_per_m);
    const double most_nm = loop.limits.max_torque_nm;
    if (!(most_nm > 0.0)) continue;
    keep_least(loop, recommend_rotational_stiffness(loop.hand_model, most_nm, rate_hz, delay_s), gains.by_turning,
               gains.rotational_nm_per_rad);
  }
  return gains;
}

namespace {

// A stiffness, where the hand feels it (" on its bumps, pressed with 8.5 N"), and the advice that keeps it to most_n_per_m.
struct StiffPart {
  double n_per_m = 0.0;
  std::string where = {};
  std::function<std::string(double most_n_per_m)> fix;
};

CheckFinding stiffer_than_loop(const std::string& name, const StiffPart& part, const SafeGains& gains, double rate_hz, double delay_s) {
  return {SceneFault::stiffer_than_loop, name, std::nullopt,
          fmt::format("{:.6g} N/m{}, but {} is safe only up to {} N/m", part.n_per_m, part.where,
                      describe_loop(*gains.by_loop, rate_hz, delay_s), text_rounded_down(gains.safe_n_per_m)),
          fmt::format("{}, or shorten the delay (hapton loop recommend)", part.fix(gains.safe_n_per_m))};
}

CheckFindings compare_stiffness(const std::string& name, const StiffPart& part, const SafeGains& gains, double rate_hz, double delay_s) {
  CheckFindings findings;
  if (gains.by_device != nullptr && part.n_per_m > gains.device_n_per_m) {
    findings.push_back({SceneFault::stiffer_than_device, name, std::nullopt,
                        fmt::format("{:.6g} N/m, but the stiffness limit of {} is {:.6g} N/m", part.n_per_m, gains.by_device->device,
                                    gains.device_n_per_m),
                        part.fix(gains.device_n_per_m)});
  }
  if (gains.by_loop != nullptr && part.n_per_m > gains.safe_n_per_m)
    findings.push_back(stiffer_than_loop(name, part, gains, rate_hz, delay_s));
  return findings;
}

StiffPart spring_part(const Stiffest& stiffest) {
  const std::string key = std::string(scene_key_of(stiffest.cause));
  return {.n_per_m = stiffest.n_per_m,
          .fix = [key](double most_n_per_m) { return fmt::format("set {} to {} or less", key, text_rounded_down(most_n_per_m)); }};
}

// The effects with the bumps lowered to this share of their height.
SurfaceEffects with_lower_bumps(SurfaceEffects effects, double share) {
  effects.bumps.height_m *= share;
  effects.maps.height.at_black *= share;
  effects.maps.height.at_white *= share;
  return effects;
}

// The largest share of the height at which the object is not stiffer than most_n_per_m; 0: there is none.
double find_share_of_height(const SceneObject& object, double most_n_per_m, double pressed_n) {
  double low = 0.0;
  double high = 1.0;
  constexpr int kHalvings = 16;  // the height of bumps is found to 2^-16 of the given one
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    const Stiffest stiffest = stiffest_by_place_of(object.material, with_lower_bumps(object.effects, middle), pressed_n);
    (stiffest.n_per_m > most_n_per_m ? high : low) = middle;
  }
  return low;
}

std::string lower_bumps(const SceneObject& object, double most_n_per_m, double pressed_n) {
  const double share = find_share_of_height(object, most_n_per_m, pressed_n);
  if (!(share > 1e-3)) return "set its stiffness_n_per_m and its bump_height_m to less";
  if (object.effects.bumps.is_on())
    return fmt::format("set its bump_height_m to {:.2g} or less, or its bump_length_m to more",
                       rounded_down(share * object.effects.bumps.height_m));
  return fmt::format("multiply its bump_height_m (of a normal map: normal_map_scale) by {:.2g} or less, or take a smoother image",
                     rounded_down(share));
}

// The part that is stiff because the normal or the stiffness of the surface changes from place to place.
StiffPart part_by_place(const SceneObject& object, double n_per_m, double pressed_n, double most_n_per_m) {
  SurfaceEffects without_stiffness_map = object.effects;
  without_stiffness_map.maps.stiffness.image = nullptr;
  const bool is_due_to_bumps = stiffest_by_place_of(object.material, without_stiffness_map, pressed_n).n_per_m > most_n_per_m;
  if (!is_due_to_bumps) {
    return {
        .n_per_m = n_per_m, .where = fmt::format(" where its stiffness_map changes, pressed with {:.2g} N", pressed_n), .fix = [](double) {
          return "set the two numbers of its stiffness_map_n_per_m nearer to each other, or take a smoother image";
        }};
  }
  return {.n_per_m = n_per_m,
          .where = fmt::format(" on its bumps, pressed with {:.2g} N", pressed_n),
          .fix = [&object, pressed_n](double most) { return lower_bumps(object, most, pressed_n); }};
}

}  // namespace

// If the spring itself is too stiff for the loop, the bumps are not checked, since lower ones would not help. The stiffness limit of a
// device holds for a wall that is pressed; over the width of a bump only the limit of the loop counts.
CheckFindings check_stiffness(const SceneObject& object, const SafeGains& gains, double rate_hz, double delay_s) {
  CheckFindings findings =
      compare_stiffness(object.name, spring_part(stiffest_spring_of(object.material, object.effects)), gains, rate_hz, delay_s);
  const auto is_limit_of_loop = [](const CheckFinding& found) { return found.fault == SceneFault::stiffer_than_loop; };
  if (std::any_of(findings.begin(), findings.end(), is_limit_of_loop)) return findings;
  const Stiffest stiffest = stiffest_by_place_of(object.material, object.effects, gains.pressed_n);
  if (gains.by_loop == nullptr || stiffest.n_per_m <= gains.safe_n_per_m) return findings;
  const StiffPart part = part_by_place(object, stiffest.n_per_m, gains.pressed_n, gains.safe_n_per_m);
  findings.push_back(stiffer_than_loop(object.name, part, gains, rate_hz, delay_s));
  return findings;
}

CheckFindings check_turning(const std::string& name, double nm_per_rad, const SafeGains& gains, double rate_hz, double delay_s) {
  if (gains.by_turning == nullptr || nm_per_rad <= gains.rotational_nm_per_rad) return {};
  const std::string most = fmt::format("{:.2g}", rounded_down(gains.rotational_nm_per_rad));
  return {{SceneFault::tool_stiffer_than_loop, name, std::nullopt,
           fmt::format("up to {:.3g} Nm/rad about its grip, but {} is safe only up to {} Nm/rad", nm_per_rad,
                       describe_loop(*gains.by_turning, rate_hz, delay_s), most),
           fmt::format("give haptics_node --rotational-stiffness {}, or shorten the delay (hapton loop recommend)", most)}};
}

CheckFindings check_stiffness(const SceneEffect& effect, const SafeGains& gains, double rate_hz, double delay_s) {
  return compare_stiffness(shown_name(effect), spring_part(stiffest_of(effect.effect)), gains, rate_hz, delay_s);
}

namespace {

// what_to_set: "its damping_ns_per_m".
void compare_damping(const std::string& name, double damping_ns_per_m, std::string_view what_to_set, const NamedLoop* by,
                     double safe_ns_per_m, double rate_hz, double delay_s, CheckFindings& findings) {
  if (by == nullptr || damping_ns_per_m <= safe_ns_per_m) return;
  const std::string most = fmt::format("{:.2g}", safe_ns_per_m > 0.0 ? rounded_down(safe_ns_per_m) : 0.0);
  findings.push_back({SceneFault::more_damped_than_loop, name, std::nullopt,
                      fmt::format("{:.6g} Ns/m of damping, but {} is safe only up to {} Ns/m", damping_ns_per_m,
                                  describe_loop(*by, rate_hz, delay_s), most),
                      fmt::format("set {} to {} or less, or shorten the delay (hapton loop recommend)", what_to_set, most)});
}

}  // namespace

CheckFindings check_damping(const SceneObject& object, const SafeGains& gains, double rate_hz, double delay_s, bool is_touched_by_tool) {
  CheckFindings findings;
  if (is_touched_by_tool) {
    compare_damping(object.name, object.material.damping_ns_per_m,
                    "its damping_ns_per_m (at the contacts of a rigid tool or a held object)", gains.by_viscosity, gains.viscosity_ns_per_m,
                    rate_hz, delay_s, findings);
  } else {
    compare_damping(object.name, object.material.damping_ns_per_m, "its damping_ns_per_m", gains.by_damping, gains.damping_ns_per_m,
                    rate_hz, delay_s, findings);
  }
  const std::string_view key = object.effects.maps.viscosity.is_on() ? "its viscosity_map_ns_per_m" : "its viscosity_ns_per_m";
  compare_damping(object.name, viscosity_of(object.effects), key, gains.by_viscosity, gains.viscosity_ns_per_m, rate_hz, delay_s, findings);
  compare_damping(object.name, drag_of(object.effects), "the drag_ns_per_m of its layers", gains.by_viscosity, gains.viscosity_ns_per_m,
                  rate_hz, delay_s, findings);
  return findings;
}

CheckFindings check_damping(const SceneEffect& effect, const SafeGains& gains, double rate_hz, double delay_s) {
  CheckFindings findings;
  compare_damping(shown_name(effect), viscosity_of(effect.effect), "its damping_ns_per_m", gains.by_viscosity, gains.viscosity_ns_per_m,
                  rate_hz, delay_s, findings);
  return findings;
}

CheckFindings check_mass(const SceneEffect& effect, std::span<const NamedLoop> loops, double rate_hz, double delay_s) {
  const auto* mass = std::get_if<MassEffect>(&effect.effect);
  if (mass == nullptr) return {};
  const NamedLoop* limiting_loop = nullptr;
  double safe_kg = mass->mass_kg;
  for (const NamedLoop& loop : loops) {
    const SampledPlant plant(make_axis_plant(loop.device_model, loop.hand_model), 1.0 / rate_hz, delay_s);
    const double safe_for_loop_kg = find_stable_mass(plant, mass->filter_s).value / kGainMargin;
    if (safe_for_loop_kg >= safe_kg) continue;
    safe_kg = safe_for_loop_kg;
    limiting_loop = &loop;
  }
  if (limiting_loop == nullptr) return {};
  return {{SceneFault::heavier_than_loop, shown_name(effect), std::nullopt,
           fmt::format("a virtual mass of {:.4g} kg, but {} is safe only up to {:.3g} kg", mass->mass_kg,
                       describe_loop(*limiting_loop, rate_hz, delay_s), safe_kg),
           "set its mass_kg to that or less, or its filter_s to more (hapton loop zwidth --mass-filter)"}};
}

CheckFindings check_softness(const SceneObject& object, std::span<const NamedLoop> loops) {
  constexpr double kDepthM = 0.02;  // deeper than a hand presses into what is meant to be touched; a free choice
  const NamedLoop* smoothest = nullptr;
  for (const NamedLoop& loop : loops) {
    if (smoothest == nullptr || loop.device_model.friction_n < smoothest->device_model.friction_n) smoothest = &loop;
  }
  const double n_per_m = object.material.stiffness_n_per_m;
  if (smoothest == nullptr || object.effects.layers.is_on() || n_per_m * kDepthM >= smoothest->device_model.friction_n) return {};
  return {{SceneFault::softer_than_device, object.name, std::nullopt,
           fmt::format("{:.6g} N/m is {:.3g} N at a depth of {:g} mm, less than the friction of {} ({:.3g} N): nobody feels it", n_per_m,
                       n_per_m * kDepthM, 1e3 * kDepthM, smoothest->device, smoothest->device_model.friction_n),
           fmt::format("set stiffness_n_per_m to some hundreds; {0:.6g} N/mm is {1:.6g} N/m", n_per_m, 1e3 * n_per_m)}};
}

namespace {

// The loop with the weakest device; null: no device has a known largest force.
const NamedLoop* find_weakest(std::span<const NamedLoop> loops) {
  const NamedLoop* weakest = nullptr;
  for (const NamedLoop& loop : loops) {
    const double most_n = loop.limits.max_force_n;
    if (most_n > 0.0 && (weakest == nullptr || most_n < weakest->limits.max_force_n)) weakest = &loop;
  }
  return weakest;
}

}  // namespace

CheckFindings check_strength(const SceneObject& object, std::span<const NamedLoop> loops) {
  const NamedLoop* weakest = find_weakest(loops);
  if (weakest == nullptr) return {};
  const double most_n = weakest->limits.max_force_n;
  CheckFindings findings;
  const auto compare = [&](double force_n, std::string_view what, std::string_view key) {
    if (!(force_n > most_n)) return;
    findings.push_back({SceneFault::stronger_than_device, object.name, std::nullopt,
                        fmt::format("{} {:.3g} N, but {} gives {:.3g} N at most", what, force_n, weakest->device, most_n),
                        fmt::format("lower {}: the device would give less than it says", key)});
  };
  const SurfaceEffects& effects = object.effects;
  for (std::size_t i = 0; i < effects.layers.count(); ++i) {
    const double pop_force_n = effects.layers[i].pop_force_n;
    if (std::isfinite(pop_force_n)) compare(pop_force_n, fmt::format("layer {} gives way at", i + 1), "its pop_force_n");
  }
  if (effects.snap.is_on()) compare(effects.snap.bound_n(), "holds with up to", "its snap_range_m or its snap_stiffness_n_per_m");
  if (effects.tap.is_on()) compare(effects.tap.bound_n(), "rings with up to", "its tap_max_force_n");
  if (effects.texture.is_on()) compare(effects.texture.bound_n(), "its recorded texture has up to", "its texture_max_force_n");
  return findings;
}

CheckFindings check_strength(const SceneEffect& effect, std::span<const NamedLoop> loops) {
  const NamedLoop* weakest = find_weakest(loops);
  if (weakest == nullptr || bound_of(effect.effect) <= weakest->limits.max_force_n) return {};
  return {
      {SceneFault::stronger_than_device, shown_name(effect), std::nullopt,
       fmt::format("up to {:.3g} N, but {} gives {:.3g} N at most", bound_of(effect.effect), weakest->device, weakest->limits.max_force_n),
       "lower its force: the device would give less than it says"}};
}

namespace {

CheckFindings compare_frequency(const std::string& name, double frequency_hz, std::string_view what_to_set, double rate_hz) {
  if (frequency_hz < 0.5 * rate_hz) return {};
  return {{SceneFault::faster_than_loop, name, std::nullopt,
           fmt::format("a vibration of {:g} Hz, but {:g} forces a second render less than {:g} Hz", frequency_hz, rate_hz, 0.5 * rate_hz),
           fmt::format("set {} to less, or raise the rate", what_to_set)}};
}

}  // namespace

CheckFindings check_frequency(const SceneObject& object, double rate_hz) {
  const TapVibration& tap = object.effects.tap;
  return tap.is_on() ? compare_frequency(object.name, tap.frequency_hz, "its tap_frequency_hz", rate_hz) : CheckFindings();
}

CheckFindings check_frequency(const SceneEffect& effect, double rate_hz) {
  const auto compare = [&](double frequency_hz) {
    return compare_frequency(shown_name(effect), frequency_hz, "its frequency_hz", rate_hz);
  };
  if (const auto* wave = std::get_if<WaveEffect>(&effect.effect)) return compare(wave->frequency_hz);
  if (const auto* burst = std::get_if<BurstEffect>(&effect.effect)) return compare(burst->frequency_hz);
  return {};
}

}  // namespace hapton
