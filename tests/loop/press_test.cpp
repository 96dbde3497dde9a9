#include "loop/press.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace hapton {
namespace {

struct Pressed {
  PressMeasures measures;
  PressPath path;
};

Pressed press(const DeviceModel& device, const HandModel& hand, double stiffness, const ForceChain::Options& link = {}) {
  WallLaw wall({.stiffness_n_per_m = stiffness});
  ForceChain chain(wall, link);
  Pressed pressed;
  pressed.path = make_press_path(hand, {.wall_n_per_m = stiffness});
  LoopSimulation simulation(chain, {.device = device, .hand = hand, .path = pressed.path.path, .start_m = pressed.path.start_m});
  std::vector<LoopRow> rows;
  const bool is_bounded = simulation.run_until(pressed.path.end_ns, &rows);
  pressed.measures = measure_press(rows, pressed.path, 1'000'000, link.encoder_step_m, is_bounded);
  return pressed;
}

const DeviceModel kIdeal{.mass_kg = 0.075, .damping_ns_per_m = 1.0};

TEST(Press, SettlesWhereForceAndSpringsBalance) {
  const PressMeasures measures = press(kIdeal, *find_hand_preset("stylus"), 1000.0).measures;
  EXPECT_TRUE(measures.is_bounded);
  EXPECT_NEAR(measures.depth_m, 1e-3, 1e-5);
  EXPECT_LT(measures.limit_cycle_m, 1e-6);
  EXPECT_GT(measures.overshoot, 0.0);
  EXPECT_GT(measures.settling_s, 0.0);
  EXPECT_LT(measures.settling_s, 0.5);
  // Passive: b > K T / 2.
  EXPECT_LT(measures.generated_j, 0.0);
}

TEST(Press, BeyondTheLimitBuzzesAndGivesEnergy) {
  ForceChain::Options link{.encoder_step_m = 3e-5, .max_force_n = 8.5};
  link.there.delay_ns = 5'000'000;
  const PressMeasures measures = press(kIdeal, *find_hand_preset("stylus"), 5000.0, link).measures;
  EXPECT_GT(measures.limit_cycle_m, 1e-4);
  EXPECT_GT(measures.buzz_n, 1.0);
  EXPECT_GT(measures.buzz_hz, 5.0);
  EXPECT_GT(measures.wall_j, 0.0);
  EXPECT_TRUE(std::isinf(measures.settling_s));
}

TEST(Press, AHandWithoutASpringPushes) {
  const Pressed pressed = press({.mass_kg = 0.075, .damping_ns_per_m = 2.0, .friction_n = 0.04}, {}, 1000.0);
  EXPECT_NEAR(pressed.measures.depth_m, 1e-3, 5e-5);
}

TEST(SpectrumPeak, FindsALine) {
  std::vector<double> signal;
  for (int i = 0; i < 1000; ++i) signal.push_back(3.0 + 0.5 * std::sin(2.0 * std::numbers::pi * 0.123 * i));
  const SpectrumPeak peak = find_spectrum_peak(signal, 1000.0, 5.0);
  EXPECT_NEAR(peak.frequency_hz, 123.0, 1.0);
  EXPECT_NEAR(peak.amplitude, 0.5, 0.01);
  EXPECT_EQ(find_spectrum_peak({1.0, 2.0}, 1000.0, 5.0).amplitude, 0.0);
}

}  // namespace
}  // namespace hapton
