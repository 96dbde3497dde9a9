#include "closed_loop/recommendation.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "closed_loop/zwidth.h"

namespace hapton {
namespace {

TEST(Recommendation, IsHalfOfWhatIsStable) {
  const DevicePreset& device = *find_device_preset("falcon");
  const HandModel hand = *find_hand_preset("light");
  const Recommendation advice = recommend_stiffness(device.model, {}, hand, 1000.0, 0.005);
  // The limit falls with the delay here, so the limit at the whole delay is the least one.
  EXPECT_DOUBLE_EQ(advice.stiffness_n_per_m, 0.5 * find_zwidth({.device = device.model, .hand = hand, .delay_s = 0.005}).stiffness.value);
  EXPECT_FALSE(advice.is_limited_by_device);
}

TEST(Recommendation, IsAtMostWhatTheDeviceIsStatedToHold) {
  const DevicePreset& device = *find_device_preset("touch");
  const Recommendation advice = recommend_stiffness(device.model, device.limits, *find_hand_preset("stylus"), 10'000.0, 0.0);
  EXPECT_EQ(advice.stiffness_n_per_m, device.limits.max_stiffness_n_per_m);
  EXPECT_TRUE(advice.is_limited_by_device);
}

// Both limits are the least over all delays up to the given one.
TEST(Recommendation, IsTheLeastOfAllShorterDelays) {
  const DevicePreset& device = *find_device_preset("omega.3");
  const HandModel hand = *find_hand_preset("stylus");
  constexpr double kDelayS = 0.2;
  double stable = 1e12;
  double passive = 1e12;
  for (int i = 0; i <= 32; ++i) {
    const ZWidth width = find_zwidth({.device = device.model, .hand = hand, .delay_s = kDelayS * i / 32});
    stable = std::min(stable, width.stiffness.value);
    passive = std::min(passive, width.passive.least_n_per_m());
  }
  const Recommendation advice = recommend_stiffness(device.model, {.max_stiffness_n_per_m = 0.0}, hand, 1000.0, kDelayS);
  EXPECT_DOUBLE_EQ(advice.stable_n_per_m, stable);
  EXPECT_DOUBLE_EQ(advice.passive_n_per_m, passive);
  EXPECT_LT(passive, stable);
  EXPECT_FALSE(advice.is_limited_by_device) << "of a device that names no limit";
}

TEST(Recommendation, OfDampingIsHalfOfTheLeastThatIsStable) {
  const DevicePreset& device = *find_device_preset("touch");
  const HandModel hand = *find_hand_preset("stylus");
  double damping = 1e12;
  double viscosity = 1e12;
  for (int i = 0; i <= 32; ++i) {
    const ZWidth width = find_zwidth({.device = device.model, .hand = hand, .delay_s = 0.02 * i / 32});
    damping = std::min(damping, width.damping_ns_per_m.value);
    viscosity = std::min(viscosity, width.viscosity_ns_per_m.value);
  }
  const Recommendation advice = recommend_stiffness(device.model, device.limits, hand, 1000.0, 0.02);
  EXPECT_DOUBLE_EQ(advice.damping_ns_per_m, 0.5 * damping);
  EXPECT_DOUBLE_EQ(advice.viscosity_ns_per_m, 0.5 * viscosity);
  EXPECT_NE(viscosity, damping);
}

// The limit of damping is found without stiffness, the limit of stiffness without damping. A material with half of both is stable.
TEST(Recommendation, AMaterialAtBothLimitsIsStable) {
  for (const DevicePreset& device : device_presets()) {
    for (const HandPreset& hand : hand_presets()) {
      for (const double rate_hz : {1000.0, 4000.0}) {
        for (const double most_ms : {0.0, 0.5, 5.0, 20.0}) {
          const Recommendation advice = recommend_stiffness(device.model, {}, hand.model, rate_hz, 1e-3 * most_ms);
          for (const double share : {0.0, 0.3, 0.7, 1.0}) {
            const SampledPlant plant(make_axis_plant(device.model, hand.model), 1.0 / rate_hz, share * 1e-3 * most_ms);
            EXPECT_LT(compute_spectral_radius(plant, {advice.stable_n_per_m / kGainMargin, advice.damping_ns_per_m}), 1.0)
                << device.name << " in hand " << hand.name << ", " << rate_hz << " Hz, " << share * most_ms << " ms";
          }
        }
      }
    }
  }
}

// A loop may be stable at some delay but not at a shorter one; the recommendation must not rise even then.
TEST(Recommendation, NeverRisesWithLatency) {
  const DevicePreset& device = *find_device_preset("omega.3");
  const HandModel hand = *find_hand_preset("stylus");
  double before = 1e9;
  for (const double delay_s : {0.0, 0.01, 0.05, 0.2}) {
    const double now = recommend_stiffness(device.model, {}, hand, 1000.0, delay_s).stiffness_n_per_m;
    EXPECT_LE(now, before);
    before = now;
  }
}

}  // namespace
}  // namespace hapton
