#include "closed_loop/press.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "closed_loop/stability.h"

namespace hapton {
namespace {

struct PressRun {
  PressMeasures measures;
  PressPath path;
  std::vector<LoopRow> rows;
};

PressRun press(const DeviceModel& device, const HandModel& hand, double stiffness, const ForceChain::Options& link = {}) {
  WallLaw wall({.stiffness_n_per_m = stiffness});
  ForceChain chain(wall, link);
  PressRun run;
  run.path = make_press_path(hand, {.wall_n_per_m = stiffness});
  LoopSimulation simulation(chain, {.device = device, .hand = hand, .path = run.path.path, .start_m = run.path.start_m});
  std::vector<LoopRow>& rows = run.rows;
  const bool is_bounded = simulation.run_until(run.path.end_ns, &rows);
  run.measures = measure_press(rows, run.path, 1'000'000, link.encoder_step_m, is_bounded);
  return run;
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
  // The wall is passive, b > K T / 2, so it gives no energy.
  EXPECT_LT(measures.generated_j, 0.0);
}

TEST(Press, BeyondTheLimitBuzzesAndGivesEnergy) {
  ForceChain::Options link{.encoder_step_m = 3e-5, .max_force_n = 8.5};
  link.to_law.delay_ns = 5'000'000;
  const PressMeasures measures = press(kIdeal, *find_hand_preset("stylus"), 5000.0, link).measures;
  EXPECT_GT(measures.limit_cycle_m, 1e-4);
  EXPECT_GT(measures.buzz_n, 1.0);
  EXPECT_GT(measures.buzz_hz, 5.0);
  EXPECT_GT(measures.wall_j, 0.0);
  EXPECT_TRUE(std::isinf(measures.settling_s));
}

// The last row of the hold is moved out of the band of 5 %. Half of the peak-to-peak motion, the measure of a limit cycle, is less.
TEST(Press, AMotionThatLeavesTheBandAgainHasNotSettled) {
  PressRun run = press(kIdeal, *find_hand_preset("stylus"), 1000.0);
  const auto row = std::find_if(run.rows.rbegin(), run.rows.rend(), [&](const LoopRow& r) { return r.time_ns < run.path.release_ns; });
  row->p_WD.x() -= 1.5 * 0.05 * run.measures.depth_m;
  EXPECT_TRUE(std::isinf(measure_press(run.rows, run.path, 1'000'000, 0.0, true).settling_s));
}

// The first force comes after the hand has left again: nothing has settled.
TEST(Press, WithoutAForceInTimeNothingSettles) {
  ForceChain::Options link;
  link.to_law.delay_ns = 2'000'000'000;
  const PressMeasures late = press(kIdeal, *find_hand_preset("stylus"), 1000.0, link).measures;
  EXPECT_FALSE(late.has_contact);
  EXPECT_TRUE(std::isinf(late.settling_s));
  EXPECT_EQ(late.depth_m, 0.0);
  EXPECT_TRUE(press(kIdeal, *find_hand_preset("stylus"), 1000.0).measures.has_contact);
}

TEST(Press, AHandWithoutASpringPushes) {
  const PressRun run = press({.mass_kg = 0.075, .damping_ns_per_m = 2.0, .friction_n = 0.04}, {}, 1000.0);
  EXPECT_NEAR(run.measures.depth_m, 1e-3, 5e-5);
}

TEST(Press, IsStillWithinTwoEncoderStepsOrAHundredthOfTheDepth) {
  constexpr double kEncoderStepM = 1e-5;
  const auto is_still = [](double depth_m, double limit_cycle_m) {
    return PressMeasures{.depth_m = depth_m, .limit_cycle_m = limit_cycle_m}.is_still(kEncoderStepM);
  };
  EXPECT_TRUE(is_still(1e-4, 2.0 * kEncoderStepM)) << "two steps are more than a hundredth of this depth";
  EXPECT_FALSE(is_still(1e-4, 2.01 * kEncoderStepM));
  EXPECT_TRUE(is_still(0.01, 0.99e-4)) << "a hundredth of this depth is more than two steps";
  EXPECT_FALSE(is_still(0.01, 1.01e-4));
  EXPECT_TRUE(is_still(-0.01, 0.99e-4)) << "outside the wall";
}

// Without encoder steps and friction: near the limit of stability a motion takes longer to die out than the second that the press lasts.
TEST(RestStiffness, OfALinearLoopIsBelowTheLimitOfStability) {
  const HandModel hand = *find_hand_preset("stylus");
  PressCase loop{.device = kIdeal, .hand = hand};
  loop.to_law.delay_ns = 5'000'000;
  const double stable = find_stable_stiffness(SampledPlant(make_axis_plant(kIdeal, hand), 1e-3, 5e-3), 0.0).value;
  const double rest = find_rest_stiffness(loop, 1e5);
  EXPECT_LT(rest, stable);
  EXPECT_GT(rest, 0.4 * stable);
}

TEST(RestStiffness, FrictionRaisesIt) {
  PressCase loop{.device = kIdeal, .hand = *find_hand_preset("light")};
  loop.to_law.delay_ns = 5'000'000;
  const double without = find_rest_stiffness(loop, 1e5);
  loop.device.friction_n = 0.3;
  EXPECT_GT(find_rest_stiffness(loop, 1e5), 1.2 * without);
  EXPECT_EQ(find_rest_stiffness(loop, 20.0), 20.0);
}

// Into a soft wall the hand moves so long that a force delayed by two seconds comes before the release; at a stiff wall none comes in time.
TEST(RestStiffness, APressWithoutAForceBeforeTheReleaseDoesNotComeToRest) {
  PressCase loop{.device = kIdeal, .hand = *find_hand_preset("stylus")};
  loop.to_law.delay_ns = 2'000'000'000;
  EXPECT_LT(find_rest_stiffness(loop, 1e5), 20.0);
}

TEST(SpectrumPeak, FindsALine) {
  std::vector<double> signal;
  for (int i = 0; i < 1000; ++i) signal.push_back(3.0 + 0.5 * std::sin(2.0 * std::numbers::pi * 0.123 * i));
  const std::vector<SpectrumPeak> spectrum = compute_spectrum(signal, 1000.0);
  ASSERT_EQ(spectrum.size(), 500U);
  EXPECT_DOUBLE_EQ(spectrum.front().frequency_hz, 1.0);
  EXPECT_DOUBLE_EQ(spectrum.back().frequency_hz, 500.0);
  const SpectrumPeak peak = find_spectrum_peak(spectrum, 5.0);
  EXPECT_NEAR(peak.frequency_hz, 123.0, 1.0);
  EXPECT_NEAR(peak.amplitude, 0.5, 0.01);
  EXPECT_TRUE(compute_spectrum({1.0, 2.0}, 1000.0).empty());
  EXPECT_EQ(find_spectrum_peak({}, 5.0).amplitude, 0.0);
}

TEST(Press, TheDepthIsThatOfHandAndWallInSeries) {
  HandModel hand;
  hand.stiffness_n_per_m = 500.0;
  EXPECT_DOUBLE_EQ(compute_press_depth_m(hand, {.press_n = 2.0, .wall_n_per_m = 1000.0}), 0.006);
  EXPECT_GT(compute_press_depth_m(hand, {.press_n = 1.0, .wall_n_per_m = 1e-300}), 1e299);
  hand.stiffness_n_per_m = 0.0;
  EXPECT_EQ(compute_press_depth_m(hand, {.press_n = 2.0, .wall_n_per_m = 1000.0}), 0.0);
}

}  // namespace
}  // namespace hapton
