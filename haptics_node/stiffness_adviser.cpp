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

}  // namespace

std::optional<StiffnessAdvice> advise_stiffness(const LoopFacts& facts) {
  if (!(facts.servo_rate_hz > 0.0)) return std::nullopt;
  std::optional<StiffnessAdvice> least;
  for (const DevicePreset* device : presets_of_device(name_of(facts))) {
    for (const HandPreset& hand : hand_presets()) {
      if (hand.name == "off") continue;  // the stylus without a hand
      const Recommendation advice =
          recommend_stiffness(device->model, device->limits, hand.model, facts.servo_rate_hz, static_cast<double>(facts.round_trip_s));
      if (!least || advice.stiffness_n_per_m < least->safe_n_per_m) {
        least = {advice.stiffness_n_per_m, std::string(device->title), std::string(hand.name), advice.is_limited_by_device};
      }
    }
  }
  return least;
}

StiffnessAdviser::StiffnessAdviser(double stiffest_n_per_m)
    : stiffest_n_per_m_(stiffest_n_per_m), considered_n_per_m_(stiffest_n_per_m), thread_(start_thread([this] { run(); })) {}

StiffnessAdviser::~StiffnessAdviser() {
  stop_.store(true);
  thread_.join();
}

void StiffnessAdviser::run() {
  // Polls, since to wake this thread would be a system call in the thread that replies to the hub.
  constexpr auto kPeriod = std::chrono::milliseconds(50);
  while (!stop_.load()) {
    if (facts_.take()) consider(facts_.value());
    const double stiffest_n_per_m = stiffest_n_per_m_.load(std::memory_order_acquire);
    if (std::exchange(considered_n_per_m_, stiffest_n_per_m) < stiffest_n_per_m) advise(considered_, stiffest_n_per_m);
    std::this_thread::sleep_for(kPeriod);
  }
}

void StiffnessAdviser::consider(const LoopFacts& facts) {
  const bool is_same_loop = facts.device == considered_.device && facts.servo_rate_hz == considered_.servo_rate_hz;
  if (is_same_loop && facts.round_trip_s < static_cast<float>(kMuchSlower) * considered_.round_trip_s) return;
  considered_ = facts;
  advise(facts, considered_n_per_m_);
}

void StiffnessAdviser::advise(const LoopFacts& facts, double stiffest_n_per_m) {
  const auto advice = advise_stiffness(facts);
  if (!advice || stiffest_n_per_m <= advice->safe_n_per_m) return;
  if (advice->is_limited_by_device) {
    log_warning("the scene has up to {:.0f} N/m, but the stiffness limit of {} is {:.0f} N/m; lower stiffness_n_per_m", stiffest_n_per_m,
                advice->device, advice->safe_n_per_m);
    return;
  }
  log_warning(
      "the scene has up to {:.0f} N/m, but {} at {:g} Hz with forces after {:.3g} ms is safe only up to {:.0f} N/m (hand: {}); lower "
      "stiffness_n_per_m, start with --coupling, or shorten the delay (see hapton loop recommend)",
      stiffest_n_per_m, advice->device, facts.servo_rate_hz, 1e3 * static_cast<double>(facts.round_trip_s), advice->safe_n_per_m,
      advice->hand);
}

}  // namespace hapton
