#include "closed_loop/random_stability.h"

#include <gtest/gtest.h>

#include <cstdint>

#include "closed_loop/stability.h"

namespace hapton {
namespace {

double exact_limit(const RandomLoop& loop) {
  const double delay_s = 1e-9 * static_cast<double>(loop.to_law.delay_ns + loop.from_law.delay_ns);
  return find_stable_stiffness(SampledPlant(make_axis_plant(loop.device, loop.hand), 1e-9 * static_cast<double>(loop.period_ns), delay_s),
                               0.0)
      .value;
}

RandomLoop stylus_loop() {
  return {.device = {.mass_kg = 0.075, .damping_ns_per_m = 0.1}, .hand = *find_hand_preset("stylus"), .to_law = {.delay_ns = 5'000'000}};
}

TEST(RandomStability, WithoutJitterAndLossIsTheExactLimit) {
  const RandomLoop loop = stylus_loop();
  EXPECT_NEAR(find_stable_stiffness_by_simulation(loop, 100.0), exact_limit(loop), 0.005 * exact_limit(loop));
}

TEST(RandomStability, JitterAndLossLowerTheLimit) {
  RandomLoop loop = stylus_loop();
  const double without_jitter = exact_limit(loop);
  loop.to_law.jitter_ns = 10'000'000;
  const double with_jitter = find_stable_stiffness_by_simulation(loop, without_jitter);
  EXPECT_LT(with_jitter, 0.95 * without_jitter);
  // The newest sample is used, so jitter of up to 10 ms lowers the limit less than 10 ms more delay would.
  RandomLoop more_delay = stylus_loop();
  more_delay.to_law.delay_ns += 10'000'000;
  EXPECT_GT(with_jitter, exact_limit(more_delay));
  loop.to_law.jitter_ns = 0;
  loop.to_law.loss = 0.5;
  EXPECT_LT(find_stable_stiffness_by_simulation(loop, without_jitter), 0.99 * without_jitter);
}

TEST(RandomStability, GrowthIsNegativeBelowTheLimitAndPositiveAboveIt) {
  RandomLoop loop = stylus_loop();
  loop.to_law.loss = 0.3;
  const double limit = find_stable_stiffness_by_simulation(loop, 100.0);
  EXPECT_LT(measure_growth_per_s(loop, 0.9 * limit), 0.0);
  EXPECT_GT(measure_growth_per_s(loop, 1.1 * limit), 0.0);
}

TEST(RandomStability, OfDampingWithoutLossIsTheExactLimit) {
  for (const char* hand : {"off", "stylus", "firm"}) {
    RandomLoop loop = stylus_loop();
    loop.hand = *find_hand_preset(hand);
    const double exact_ns_per_m = find_stable_damping(SampledPlant(make_axis_plant(loop.device, loop.hand), 1e-3, 5e-3), 0.0).value;
    EXPECT_NEAR(find_stable_damping_by_simulation(loop, 3.0 * exact_ns_per_m), exact_ns_per_m, 0.01 * exact_ns_per_m) << hand;
    EXPECT_NEAR(find_stable_damping_by_simulation(loop, 0.3 * exact_ns_per_m), exact_ns_per_m, 0.01 * exact_ns_per_m) << hand;
    loop.to_law.loss = 0.5;
    EXPECT_LT(find_stable_damping_by_simulation(loop, exact_ns_per_m), 0.99 * exact_ns_per_m) << hand;
  }
}

TEST(MeanDelay, WithoutJitterAndLossIsTheDelay) {
  for (const std::int64_t delay_ns : {0, 300'000, 5'000'000, 500'000'000}) {
    EXPECT_NEAR(measure_mean_delay_s({.to_law = {.delay_ns = delay_ns / 3}, .from_law = {.delay_ns = delay_ns - delay_ns / 3}}),
                1e-9 * static_cast<double>(delay_ns), 1e-9);
  }
}

// A sample gets a force with probability s, independently of the others: on average (1 - s) / s samples in a row get none.
TEST(MeanDelay, OfLossIsThatOfAGeometricSeries) {
  for (const double loss : {0.1, 0.3, 0.6}) {
    const double share = (1.0 - loss) * (1.0 - loss);
    const RandomLoop loop{.to_law = {.delay_ns = 2'000'000, .loss = loss}, .from_law = {.loss = loss}, .seed = 3, .seconds = 200.0};
    EXPECT_NEAR(measure_mean_delay_s(loop), 2e-3 + 1e-3 * (1.0 - share) / share, 0.05 * 1e-3 * (1.0 - share) / share) << loss;
  }
}

// Jitter uniform in [0, J] one way, over many samples: a sample of age a has arrived with probability a / J. The probability that no sample
// younger than y has arrived is the product of 1 - a / J over the ages below y; the youngest age is uniform in a period.
double mean_delay_of_jitter(double jitter_s, double period_s) {
  constexpr int kYoungestAges = 100;
  double sum_s = 0.0;
  for (int i = 0; i < kYoungestAges; ++i) {
    const double youngest_s = period_s * (i + 0.5) / kYoungestAges;
    sum_s += youngest_s;
    double none_arrived = 1.0;
    for (double age_s = youngest_s; age_s < jitter_s; age_s += period_s) sum_s += period_s * (none_arrived *= 1.0 - age_s / jitter_s);
  }
  return sum_s / kYoungestAges - 0.5 * period_s;
}

TEST(MeanDelay, OfJitterIsThatOfTheNewestSample) {
  for (const std::int64_t jitter_ns : {500'000, 3'000'000, 100'000'000}) {
    const RandomLoop loop{.to_law = {.jitter_ns = jitter_ns}, .seed = 5, .seconds = 200.0};
    const double expected_s = mean_delay_of_jitter(1e-9 * static_cast<double>(jitter_ns), 1e-3);
    EXPECT_NEAR(measure_mean_delay_s(loop), expected_s, 0.02 * expected_s) << jitter_ns;
    EXPECT_LE(expected_s, 0.5e-9 * static_cast<double>(jitter_ns) * (1.0 + 1e-9)) << "only the newest sample counts";
  }
}

}  // namespace
}  // namespace hapton
