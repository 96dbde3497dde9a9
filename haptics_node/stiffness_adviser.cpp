#include "haptics_node/stiffness_adviser.h"

#include <algorithm>
#include <chrono>
#include <string_view>
#include <utility>

#include "loop/device_model.h"
#include "loop/hand_model.h"
#include "loop/recommendation.h"
#include "runtime/log.h"
#include "runtime/start_thread.h"

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
      what == "viscosity" ? "viscosity_ns_per_m, or damping_ns_per_m of viscous effects (of materials, too, with a rigid tool)"
                          : "damping_ns_per_m of materials");
}

// 0 where it has not risen.
double if_risen(double before, double now) { return now > before ? now : 0.0; }

}  // namespace

std::optional<StiffnessAdvice> advise_stiffness(const LoopFacts& facts) {
  if (!(facts.servo_rate_hz > 0.0)) return std::nullopt;
  StiffnessAdvice least;
  for (const DevicePreset* device : presets_of_device(name_of(facts))) {
    for (const HandPreset& hand : hand_presets()) {
      if (hand.name == "off") continue;  // the stylus without a hand
      const Recommendation advice =
          recommend_stiffness(device->model, device->limits, hand.model, facts.servo_rate_hz, static_cast<double>(facts.round_trip_s));
      if (least.by_stiffness.device.empty() || advice.stiffness_n_per_m < least.safe_n_per_m) {
        least.is_limited_by_device = advice.is_limited_by_device;
      }
      keep_least_of(advice.stiffness_n_per_m, *device, hand, least.safe_n_per_m, least.by_stiffness);
      keep_least_of(advice.damping_ns_per_m, *device, hand, least.damping_ns_per_m, least.by_damping);
      keep_least_of(advice.viscosity_ns_per_m, *device, hand, least.viscosity_ns_per_m, least.by_viscosity);
    }
  }
  return least.by_stiffness.device.empty() ? std::nullopt : std::optional(least);
}

StiffnessAdviser::StiffnessAdviser(const LargestGains& gains)
    : stiffness_n_per_m_(gains.stiffness_n_per_m),
      damping_ns_per_m_(gains.damping_ns_per_m),
      viscosity_ns_per_m_(gains.viscosity_ns_per_m),
      considered_gains_(gains),
      thread_(start_thread([this] { run(); })) {}

StiffnessAdviser::~StiffnessAdviser() {
  stop_.store(true);
  thread_.join();
}

void StiffnessAdviser::set_gains(const LargestGains& gains) noexcept {
  stiffness_n_per_m_.store(gains.stiffness_n_per_m, std::memory_order_release);
  damping_ns_per_m_.store(gains.damping_ns_per_m, std::memory_order_release);
  viscosity_ns_per_m_.store(gains.viscosity_ns_per_m, std::memory_order_release);
}

void StiffnessAdviser::run() {
  // Polls, since to wake this thread would be a system call in the thread that replies to the hub.
  constexpr auto kPeriod = std::chrono::milliseconds(50);
  while (!stop_.load()) {
    if (facts_.take()) consider(facts_.value());
    const LargestGains now{.stiffness_n_per_m = stiffness_n_per_m_.load(std::memory_order_acquire),
                           .damping_ns_per_m = damping_ns_per_m_.load(std::memory_order_acquire),
                           .viscosity_ns_per_m = viscosity_ns_per_m_.load(std::memory_order_acquire)};
    const LargestGains before = std::exchange(considered_gains_, now);
    const LargestGains risen{.stiffness_n_per_m = if_risen(before.stiffness_n_per_m, now.stiffness_n_per_m),
                             .damping_ns_per_m = if_risen(before.damping_ns_per_m, now.damping_ns_per_m),
                             .viscosity_ns_per_m = if_risen(before.viscosity_ns_per_m, now.viscosity_ns_per_m)};
    if (risen.any()) advise(considered_, risen);
    looks_.fetch_add(1, std::memory_order_release);
    std::this_thread::sleep_for(kPeriod);
  }
}

void StiffnessAdviser::consider(const LoopFacts& facts) {
  const bool is_same_loop = facts.device == considered_.device && facts.servo_rate_hz == considered_.servo_rate_hz;
  if (is_same_loop && facts.round_trip_s < static_cast<float>(kMuchSlower) * considered_.round_trip_s) return;
  considered_ = facts;
  advise(facts, considered_gains_);
}

void StiffnessAdviser::advise(const LoopFacts& facts, const LargestGains& gains) {
  const auto advice = advise_stiffness(facts);
  if (!advice) return;
  warn_of_damping("damping", gains.damping_ns_per_m, advice->damping_ns_per_m, advice->by_damping, facts);
  warn_of_damping("viscosity", gains.viscosity_ns_per_m, advice->viscosity_ns_per_m, advice->by_viscosity, facts);
  if (gains.stiffness_n_per_m <= advice->safe_n_per_m) return;
  if (advice->is_limited_by_device) {
    log_warning("the scene has up to {:.0f} N/m, but the stiffness limit of {} is {:.0f} N/m; lower stiffness_n_per_m",
                gains.stiffness_n_per_m, advice->by_stiffness.device, advice->safe_n_per_m);
    return;
  }
  log_warning(
      "the scene has up to {:.0f} N/m, but {} at {:g} Hz with forces after {:.3g} ms is safe only up to {:.0f} N/m (hand: {}); lower "
      "stiffness_n_per_m, start with --coupling, or shorten the delay (see hapton loop recommend)",
      gains.stiffness_n_per_m, advice->by_stiffness.device, facts.servo_rate_hz, 1e3 * static_cast<double>(facts.round_trip_s),
      advice->safe_n_per_m, advice->by_stiffness.hand);
}

}  // namespace hapton
