#include "loop/random_stability.h"

#include <gtest/gtest.h>

#include "loop/stability.h"

namespace hapton {
namespace {

double exact(const RandomLoop& loop) {
  const double delay_s = 1e-9 * static_cast<double>(loop.there.delay_ns + loop.back.delay_ns);
  return find_stable_stiffness(SampledPlant(make_axis_plant(loop.device, loop.hand), 1e-9 * static_cast<double>(loop.period_ns), delay_s),
                               0.0)
      .value;
}

RandomLoop stylus_loop() {
  return {.device = {.mass_kg = 0.075, .damping_ns_per_m = 0.1}, .hand = *find_hand_preset("stylus"), .there = {.delay_ns = 5'000'000}};
}

TEST(RandomStability, WithoutChanceIsTheExactLimit) {
  const RandomLoop loop = stylus_loop();
  EXPECT_NEAR(find_stable_stiffness_by_simulation(loop, 100.0), exact(loop), 0.005 * exact(loop));
}

TEST(RandomStability, JitterAndLossLowerTheLimit) {
  RandomLoop loop = stylus_loop();
  const double still = exact(loop);
  loop.there.jitter_ns = 10'000'000;
  const double jittered = find_stable_stiffness_by_simulation(loop, still);
  EXPECT_LT(jittered, 0.95 * still);
  // The newest sample wins, so that less than the mean of the jitter comes on top.
  RandomLoop later = stylus_loop();
  later.there.delay_ns += 10'000'000;
  EXPECT_GT(jittered, exact(later));
  loop.there.jitter_ns = 0;
  loop.there.loss = 0.5;
  EXPECT_LT(find_stable_stiffness_by_simulation(loop, still), 0.99 * still);
}

TEST(RandomStability, GrowthHasTheSignOfTheLimit) {
  RandomLoop loop = stylus_loop();
  loop.there.loss = 0.3;
  const double limit = find_stable_stiffness_by_simulation(loop, 100.0);
  EXPECT_LT(measure_growth_per_s(loop, 0.9 * limit), 0.0);
  EXPECT_GT(measure_growth_per_s(loop, 1.1 * limit), 0.0);
}

}  // namespace
}  // namespace hapton
