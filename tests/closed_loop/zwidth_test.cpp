#include "closed_loop/zwidth.h"

#include <gtest/gtest.h>

#include <numbers>

namespace hapton {
namespace {

ZWidthCase slow_amplifier() {
  ZWidthCase loop;
  loop.device = {.mass_kg = 0.2, .damping_ns_per_m = 2.0, .friction_n = 0.3, .encoder_step_m = 1e-4, .amplifier_hz = 50.0};
  loop.hand = {0.1, 3.0, 100.0};
  loop.rate_hz = 500.0;
  loop.delay_s = 0.004;
  loop.wall_damping_ns_per_m = 0.5;
  return loop;
}

// Each limit equals what the function of its own theory gives for the same case.
TEST(ZWidth, IsTheLimitsOfTheCase) {
  const ZWidthCase loop = slow_amplifier();
  const ZWidth width = find_zwidth(loop);
  const SampledPlant plant(make_axis_plant(loop.device, loop.hand), 0.002, 0.004);
  EXPECT_DOUBLE_EQ(width.stiffness.value, find_stable_stiffness(plant, 0.5).value);
  EXPECT_DOUBLE_EQ(width.damping_ns_per_m.value, find_stable_damping(plant, 0.0).value);
  const PassivityCase passivity{.period_s = 0.002,
                                .delay_s = 0.004,
                                .damping_ns_per_m = 2.0,
                                .amplifier_s = 1.0 / (2.0 * std::numbers::pi * 50.0),
                                .friction_n = 0.3,
                                .encoder_step_m = 1e-4,
                                .wall_damping_ns_per_m = 0.5};
  EXPECT_NEAR(width.passive.viscous_n_per_m, find_passive_stiffness(passivity).viscous_n_per_m, 1e-6);
  EXPECT_NEAR(width.passive.quantised_n_per_m, 2.0 * 0.3 / 1e-4, 1e-6);
  EXPECT_EQ(width.passive_damping_ns_per_m, 2.0);
  EXPECT_NEAR(width.linear_rule_n_per_m, (2.0 + 3.0) / (0.001 + 0.004), 1e-9);
}

TEST(ZWidth, WithoutAmplifierLagThePassiveLimitIsHigher) {
  ZWidthCase loop = slow_amplifier();
  const double lagging = find_zwidth(loop).passive.viscous_n_per_m;
  loop.device.amplifier_hz = 0.0;
  const PassivityCase passivity{.period_s = 0.002, .delay_s = 0.004, .damping_ns_per_m = 2.0, .wall_damping_ns_per_m = 0.5};
  EXPECT_NEAR(find_zwidth(loop).passive.viscous_n_per_m, find_passive_stiffness(passivity).viscous_n_per_m, 1e-6);
  EXPECT_GT(find_zwidth(loop).passive.viscous_n_per_m, lagging);
}

}  // namespace
}  // namespace hapton
