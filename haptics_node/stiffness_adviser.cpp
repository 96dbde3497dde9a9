#include "haptics_node/stiffness_adviser.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <string_view>
#include <utility>

#include "closed_loop/device_model.h"
#include "closed_loop/hand_model.h"
#include "closed_loop/recommendation.h"
#include "closed_loop/turning_axis.h"
#include "core/base/rounded_down.h"
#include "runtime/log.h"
#include "runtime/start_thread.h"
#include "scene/scene_key.h"

namespace hapton {
namespace {

std::string_view name_of(const LoopFacts& facts) {
  const auto end = std::find(facts.device.begin(), facts.device.end(), '\0');
  return {facts.device.data(), static_cast<std::size_t>(end - facts.device.begin())};
}

void keep_least_of(double value, const DevicePreset& device, const HandPreset& hand, double& least, StiffnessAdvice::Loop& by) {
  if (!by.device.empty() && value >= least) return;
  least = value;
  by = {std::string(device.title), std::string(hand.name)};
}

void warn_of_damping(std::string_view what, double ns_per_m, double safe_ns_per_m, const StiffnessAdvice::Loop& by,
                     const LoopFacts& facts) {
  if (ns_per_m <= safe_ns_per_m) return;
  log_warning(
      "the scene has up to {:.3g} Ns/m of {}, but {} at {:g} Hz with forces after {:.3g} ms is safe only up to {:.3g} Ns/m (hand: {}); "
      "lower {}, or shorten the delay (see hapton loop recommend)",
      ns_per_m, what, by.device, facts.servo_rate_hz, 1e3 * static_cast<double>(facts.round_trip_s), safe_ns_per_m, by.hand,
      what == "viscosity"
          ? "viscosity_ns_per_m, drag_ns_per_m of layers or damping_ns_per_m of viscous effects (of materials, too, with a rigid tool)"
          : "damping_ns_per_m of materials");
}

std::string_view where_of(StiffCause cause) {
  switch (cause) {
    case StiffCause::spring_effect:
      return " in an effect of type spring";
    case StiffCause::snap_effect:
      return " in an effect of type magnet, line_snap or plane_snap";
    case StiffCause::gravity_well:
      return " in an effect of type gravity_well";
    case StiffCause::none:
    case StiffCause::spring:
    case StiffCause::stiffness_map:
    case StiffCause::progressive:
    case StiffCause::layers:
    case StiffCause::surface_snap:
    case StiffCause::bumps:
      break;
  }
  return "";
}

// True: the stiffness comes from a material, so --coupling can lower it.
bool is_of_material(StiffCause cause) {
  return cause == StiffCause::none || cause == StiffCause::spring || cause == StiffCause::stiffness_map || cause == StiffCause::progressive;
}

// "PHANToM Model A at 1000 Hz with forces after 10 ms is safe only up to 2000 N/m (hand: light)".
std::string describe_limit(const StiffnessAdvice::Loop& by, double safe_n_per_m, const LoopFacts& facts) {
  return fmt::format("{} at {:g} Hz with forces after {:.3g} ms is safe only up to {:.0f} N/m (hand: {})", by.device, facts.servo_rate_hz,
                     1e3 * static_cast<double>(facts.round_trip_s), safe_n_per_m, by.hand);
}

void warn_of_stiffness(const LargestGains& gains, const StiffnessAdvice& advice, const LoopFacts& facts) {
  if (gains.stiffness_n_per_m <= advice.safe_n_per_m) return;
  const std::string has = fmt::format("the scene has up to {:.0f} N/m{}", gains.stiffness_n_per_m, where_of(gains.cause));
  if (advice.is_limited_by_device) {
    log_warning("{}, but the stiffness limit of {} is {:.0f} N/m; lower {}", has, advice.by_stiffness.device, advice.safe_n_per_m,
                scene_key_of(gains.cause));
    return;
  }
  log_warning("{}, but {}; lower {}{}, or shorten the delay (see hapton loop recommend)", has,
              describe_limit(advice.by_stiffness, advice.safe_n_per_m, facts), scene_key_of(gains.cause),
              is_of_material(gains.cause) ? ", start with --coupling" : "");
}

void warn_of_places(const LargestGains& gains, const StiffnessAdvice& advice, const LoopFacts& facts) {
  const double stiffness_n_per_m = gains.by_place_at(advice.pressed_n);
  if (stiffness_n_per_m <= advice.loop_n_per_m) return;
  const bool is_of_bumps = gains.place_cause == StiffCause::bumps;
  log_warning("the scene has up to {:.0f} N/m {}, pressed with {:.2g} N, but {}; {}, or shorten the delay (see hapton check)",
              stiffness_n_per_m, is_of_bumps ? "on bumps" : "where a stiffness_map changes", advice.pressed_n,
              describe_limit(advice.by_loop, advice.loop_n_per_m, facts),
              is_of_bumps ? "lower bump_height_m (of a normal map: normal_map_scale)"
                          : "set the two numbers of stiffness_map_n_per_m nearer to each other");
}

void warn_of_turning(double nm_per_rad, const StiffnessAdvice& advice, const LoopFacts& facts) {
  if (!(advice.rotational_nm_per_rad > 0.0) || nm_per_rad <= advice.rotational_nm_per_rad) return;
  const double most = rounded_down(advice.rotational_nm_per_rad);
  log_warning(
      "the stylus holds a tool with {:.3g} Nm/rad, but a stylus with motors at {:g} Hz with torques after {:.3g} ms is safe only up to "
      "{:.2g} "
      "Nm/rad (hand: {}); give haptics_node --rotational-stiffness {:.2g}, or shorten the delay (see hapton loop recommend)",
      nm_per_rad, facts.servo_rate_hz, 1e3 * static_cast<double>(facts.round_trip_s), most, advice.by_turning, most);
}

void add_turning(const LoopFacts& facts, StiffnessAdvice& advice) {
  if (!(facts.max_torque_nm > 0.0F)) return;
  for (const HandPreset& hand : hand_presets()) {
    if (hand.name == "off") continue;
    const double safe = recommend_rotational_stiffness(hand.model, static_cast<double>(facts.max_torque_nm), facts.servo_rate_hz,
                                                       static_cast<double>(facts.round_trip_s));
    if (!advice.by_turning.empty() && safe >= advice.rotational_nm_per_rad) continue;
    advice.rotational_nm_per_rad = safe;
    advice.by_turning = hand.name;
  }
}

// The value now, or 0 if it has not risen.
double if_risen(double before, double now) { return now > before ? now : 0.0; }

}  // namespace

std::optional<StiffnessAdvice> advise_stiffness(const LoopFacts& facts) {
  if (!(facts.servo_rate_hz > 0.0)) return std::nullopt;
  StiffnessAdvice least;
  least.pressed_n = 0.0;
  for (const DevicePreset* device : presets_of_device(name_of(facts))) {
    const double most_n = device->limits.max_force_n;
    least.pressed_n = std::max(least.pressed_n, most_n > 0.0 ? std::min(most_n, kMaxPressedN) : kMaxPressedN);
    for (const HandPreset& hand : hand_presets()) {
      if (hand.name == "off") continue;  // a stylus that no hand holds
      const Recommendation advice =
          recommend_stiffness(device->model, device->limits, hand.model, facts.servo_rate_hz, static_cast<double>(facts.round_trip_s));
      if (least.by_stiffness.device.empty() || advice.stiffness_n_per_m < least.safe_n_per_m) {
        least.is_limited_by_device = advice.is_limited_by_device;
      }
      keep_least_of(advice.stiffness_n_per_m, *device, hand, least.safe_n_per_m, least.by_stiffness);
      keep_least_of(advice.stable_n_per_m / kGainMargin, *device, hand, least.loop_n_per_m, least.by_loop);
      keep_least_of(advice.damping_ns_per_m, *device, hand, least.damping_ns_per_m, least.by_damping);
      keep_least_of(advice.viscosity_ns_per_m, *device, hand, least.viscosity_ns_per_m, least.by_viscosity);
    }
  }
  if (least.by_stiffness.device.empty()) return std::nullopt;
  add_turning(facts, least);
  return least;
}

StiffnessAdviser::StiffnessAdviser(const LargestGains& gains)
    : stiffness_n_per_m_(gains.stiffness_n_per_m),
      cause_(gains.cause),
      by_place_n_per_m_(gains.by_place_n_per_m),
      of_pressing_n_per_m_(gains.of_pressing_n_per_m),
      place_cause_(gains.place_cause),
      damping_ns_per_m_(gains.damping_ns_per_m),
      viscosity_ns_per_m_(gains.viscosity_ns_per_m),
      rotational_nm_per_rad_(gains.rotational_nm_per_rad),
      checked_gains_(gains),
      thread_(start_thread([this] { run(); })) {}

StiffnessAdviser::~StiffnessAdviser() {
  stop_.store(true);
  thread_.join();
}

// Stores each cause before its stiffness. A reader loads the stiffness first, so the cause that it gets is at least as new.
void StiffnessAdviser::set_gains(const LargestGains& gains) noexcept {
  cause_.store(gains.cause, std::memory_order_release);
  stiffness_n_per_m_.store(gains.stiffness_n_per_m, std::memory_order_release);
  of_pressing_n_per_m_.store(gains.of_pressing_n_per_m, std::memory_order_release);
  place_cause_.store(gains.place_cause, std::memory_order_release);
  by_place_n_per_m_.store(gains.by_place_n_per_m, std::memory_order_release);
  damping_ns_per_m_.store(gains.damping_ns_per_m, std::memory_order_release);
  viscosity_ns_per_m_.store(gains.viscosity_ns_per_m, std::memory_order_release);
  note_tool(gains.rotational_nm_per_rad);
}

void StiffnessAdviser::note_tool(double nm_per_rad) noexcept {
  double largest = rotational_nm_per_rad_.load(std::memory_order_relaxed);
  while (nm_per_rad > largest && !rotational_nm_per_rad_.compare_exchange_weak(largest, nm_per_rad, std::memory_order_release)) {
  }
}

LargestGains StiffnessAdviser::read_gains() const noexcept {
  LargestGains gains{.stiffness_n_per_m = stiffness_n_per_m_.load(std::memory_order_acquire)};
  gains.cause = cause_.load(std::memory_order_acquire);
  gains.by_place_n_per_m = by_place_n_per_m_.load(std::memory_order_acquire);
  gains.of_pressing_n_per_m = of_pressing_n_per_m_.load(std::memory_order_acquire);
  gains.place_cause = place_cause_.load(std::memory_order_acquire);
  gains.damping_ns_per_m = damping_ns_per_m_.load(std::memory_order_acquire);
  gains.viscosity_ns_per_m = viscosity_ns_per_m_.load(std::memory_order_acquire);
  gains.rotational_nm_per_rad = rotational_nm_per_rad_.load(std::memory_order_acquire);
  return gains;
}

void StiffnessAdviser::run() {
  // Polls, because waking this thread would be a system call in the thread that replies to the hub.
  constexpr auto kPeriod = std::chrono::milliseconds(50);
  while (!stop_.load()) {
    if (facts_.take()) consider(facts_.value());
    const LargestGains now = read_gains();
    const LargestGains before = std::exchange(checked_gains_, now);
    const LargestGains risen{.stiffness_n_per_m = if_risen(before.stiffness_n_per_m, now.stiffness_n_per_m),
                             .cause = now.cause,
                             .by_place_n_per_m = if_risen(before.by_place_n_per_m, now.by_place_n_per_m),
                             .of_pressing_n_per_m = now.of_pressing_n_per_m,
                             .place_cause = now.place_cause,
                             .damping_ns_per_m = if_risen(before.damping_ns_per_m, now.damping_ns_per_m),
                             .viscosity_ns_per_m = if_risen(before.viscosity_ns_per_m, now.viscosity_ns_per_m),
                             .rotational_nm_per_rad = if_risen(before.rotational_nm_per_rad, now.rotational_nm_per_rad)};
    if (risen.any()) advise(checked_facts_, risen);
    checks_.fetch_add(1, std::memory_order_release);
    std::this_thread::sleep_for(kPeriod);
  }
}

void StiffnessAdviser::consider(const LoopFacts& facts) {
  const bool is_same_loop = facts.device == checked_facts_.device && facts.servo_rate_hz == checked_facts_.servo_rate_hz &&
                            facts.max_torque_nm == checked_facts_.max_torque_nm;
  if (is_same_loop && facts.round_trip_s < static_cast<float>(kMuchSlower) * checked_facts_.round_trip_s) return;
  checked_facts_ = facts;
  advise(facts, checked_gains_);
}

void StiffnessAdviser::advise(const LoopFacts& facts, const LargestGains& gains) {
  const auto advice = advise_stiffness(facts);
  if (!advice) return;
  warn_of_damping("damping", gains.damping_ns_per_m, advice->damping_ns_per_m, advice->by_damping, facts);
  warn_of_damping("viscosity", gains.viscosity_ns_per_m, advice->viscosity_ns_per_m, advice->by_viscosity, facts);
  warn_of_stiffness(gains, *advice, facts);
  warn_of_places(gains, *advice, facts);
  warn_of_turning(gains.rotational_nm_per_rad, *advice, facts);
}

}  // namespace hapton
