#include "closed_loop/stability.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "closed_loop/passivity.h"

namespace hapton {
namespace {

SampledPlant ideal(double mass_kg, double damping, double stiffness, double period_s, double delay_s) {
  return SampledPlant(make_axis_plant({.mass_kg = mass_kg, .damping_ns_per_m = damping}, {.stiffness_n_per_m = stiffness}), period_s,
                      delay_s);
}

struct LimitCase {
  double mass_kg, damping, stiffness, delay_s, expected, linear_rule;
};

// Largest stable stiffness from the eigenvalues of the exactly sampled loop at 1 kHz, computed without this code and rounded to 1 N/m.
constexpr LimitCase kLimitCases[] = {
    {0.875, 5.5, 30.0, 0.0, 11'012.0, 11'000.0},
    {0.875, 5.5, 30.0, 0.1, 63.0, 55.0},
    {0.225, 5.0, 500.0, 0.01, 513.0, 476.0},
    {0.225, 5.0, 500.0, 0.1, 359.0, 50.0},
};

TEST(StableStiffness, AgreesWithIndependentlyComputedValues) {
  for (const LimitCase& limit_case : kLimitCases) {
    const SampledPlant plant = ideal(limit_case.mass_kg, limit_case.damping, limit_case.stiffness, 1e-3, limit_case.delay_s);
    EXPECT_EQ(std::round(find_stable_stiffness(plant, 0.0).value), limit_case.expected);
    EXPECT_EQ(std::round(find_stable_stiffness_by_eigenvalues(plant, 0.0, 10.0, 1.5)), limit_case.expected);
    EXPECT_EQ(std::round(linear_rule_n_per_m(limit_case.damping, 1e-3, limit_case.delay_s)), limit_case.linear_rule);
  }
}

// A random device in a random hand, at a random rate and delay.
struct RandomLoop {
  explicit RandomLoop(std::mt19937_64& random) {
    const auto uniform = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
    const auto by_ratio = [&](double low, double high) { return low * std::pow(high / low, uniform(0.0, 1.0)); };
    const auto devices = device_presets();
    device = devices[std::uniform_int_distribution<std::size_t>(0, devices.size() - 1)(random)].model;
    device = device.with_modes(std::uniform_int_distribution<int>(0, 2)(random));
    if (uniform(0.0, 1.0) < 0.2) {
      device.mode_count = 2;
      device.modes[0] = {0.3 * device.mass_kg, by_ratio(1000.0, 20'000.0), by_ratio(0.5, 5.0)};
      device.modes[1] = {0.2 * device.mass_kg, by_ratio(1000.0, 20'000.0), by_ratio(0.5, 5.0)};
    }
    if (uniform(0.0, 1.0) < 0.3) device.amplifier_hz = by_ratio(100.0, 3000.0);
    // One device in ten is held by nobody.
    if (uniform(0.0, 1.0) < 0.9) hand = {by_ratio(0.05, 1.0), by_ratio(1.0, 25.0), uniform(0.0, 1000.0)};
    period_s = 1.0 / by_ratio(250.0, 20'000.0);
    // The delay is at most 40 periods, because the time for the eigenvalues grows with the cube of their number.
    delay_s = uniform(0.0, 1.0) < 0.2 ? 0.0 : std::min(0.5, uniform(0.0, 40.0) * period_s);
    damping = uniform(0.0, 1.0) < 0.5 ? 0.0 : by_ratio(0.1, 5.0);
  }

  DeviceModel device;
  HandModel hand;
  double period_s;
  double delay_s;
  double damping;
};

// Compares the limit, found at the crossing of the unit circle, with the eigenvalues: at 0.995, 0.5 and 0.1 of it every loop is stable, at
// 1.005 of it none is.
TEST(StableStiffness, AgreesWithTheEigenvaluesWithinHalfAPercentOver1000Loops) {
  constexpr std::uint64_t kSeed = 16;
  std::mt19937_64 random(kSeed);
  int unstable_by_damping = 0;
  for (int i = 0; i < 1000; ++i) {
    const RandomLoop loop(random);
    const SampledPlant plant(make_axis_plant(loop.device, loop.hand), loop.period_s, loop.delay_s);
    const double limit = find_stable_stiffness(plant, loop.damping).value;
    const auto radius = [&](double stiffness) { return compute_spectral_radius(plant, {stiffness, loop.damping}); };
    SCOPED_TRACE(::testing::Message() << "seed " << kSeed << ", loop " << i << ": " << loop.device.mass_kg << " kg, " << loop.period_s
                                      << " s, delay " << loop.delay_s << " s, damping " << loop.damping << ", limit " << limit);
    if (limit == 0.0) {
      // The damping of the wall alone makes the loop unstable.
      ++unstable_by_damping;
      ASSERT_GT(loop.damping, 0.0);
      ASSERT_GE(radius(0.0), 1.0 - 1e-9);
      continue;
    }
    for (const double share : {0.1, 0.5, 0.995}) ASSERT_LT(radius(share * limit), 1.0) << share;
    ASSERT_GT(radius(1.005 * limit), 1.0);
  }
  EXPECT_LT(unstable_by_damping, 300);
}

// Whether a wall of this stiffness lets a motion grow. Steps the recurrence x[k+1] = transition x[k] + older u + newer u, so it does not
// search for roots.
bool grows(const SampledPlant& plant, double stiffness) {
  SampledPlant::Vector state = SampledPlant::Vector::Zero(plant.transition().rows());
  state[0] = 1e-3;
  std::vector<double> commands(static_cast<std::size_t>(plant.whole_periods()) + 2, 0.0);
  const auto size_over = [&](int samples) {
    double largest = 0.0;
    for (int k = 0; k < samples; ++k) {
      commands.insert(commands.begin(), -stiffness * state[0]);
      commands.pop_back();
      state =
          plant.transition() * state + plant.newer_response() * commands[commands.size() - 2] + plant.older_response() * commands.back();
      largest = std::max(largest, std::fabs(state[0]));
    }
    return largest;
  };
  const int half_samples = 200 * (plant.whole_periods() + 1) + 20'000;
  const double first = size_over(half_samples);
  return size_over(half_samples) > first;
}

TEST(StableStiffness, IsWhereAMotionBeginsToGrow) {
  for (const LimitCase& limit_case : kLimitCases) {
    const SampledPlant plant = ideal(limit_case.mass_kg, limit_case.damping, limit_case.stiffness, 1e-3, limit_case.delay_s + 0.37e-3);
    const double limit = find_stable_stiffness(plant, 0.0).value;
    EXPECT_FALSE(grows(plant, 0.99 * limit)) << limit;
    EXPECT_TRUE(grows(plant, 1.01 * limit)) << limit;
  }
}

TEST(StableStiffness, IsZeroWhereNothingDamps) {
  EXPECT_EQ(find_stable_stiffness(ideal(0.1, 0.0, 0.0, 1e-3, 0.0), 0.0).value, 0.0);
  EXPECT_EQ(find_stable_stiffness(ideal(0.1, 0.0, 100.0, 1e-3, 0.0), 0.0).value, 0.0);
}

TEST(StableStiffness, AFreeDeviceWithDampingHasALimit) {
  // A mass with damping, held by nobody: the limit is about b / (T/2 + delay).
  const double limit = find_stable_stiffness(ideal(0.5, 2.0, 0.0, 1e-3, 1e-3), 0.0).value;
  EXPECT_NEAR(limit, 2.0 / 1.5e-3, 0.02 * 2.0 / 1.5e-3);
}

TEST(StableStiffness, NamesTheFrequencyOfItsOscillation) {
  const SampledPlant plant = ideal(0.875, 5.5, 30.0, 1e-3, 0.0);
  const StabilityLimit limit = find_stable_stiffness(plant, 0.0);
  // The frequency is about sqrt(K / M) / 2 pi.
  EXPECT_NEAR(limit.frequency_hz, std::sqrt(limit.value / 0.875) / 6.2832, 0.02 * limit.frequency_hz);
}

TEST(StableStiffness, AgreesAtLongDelaysAndHighRates) {
  // 500 ms at 20 kHz is 10,000 periods: at such a delay the limit hardly depends on the rate.
  const double fast = find_stable_stiffness(ideal(0.225, 5.0, 500.0, 1.0 / 20'000.0, 0.5), 0.0).value;
  const double slow = find_stable_stiffness(ideal(0.225, 5.0, 500.0, 1e-3, 0.5 - 0.475e-3), 0.0).value;
  EXPECT_NEAR(fast, slow, 1e-4 * slow);
}

TEST(StableDamping, AgreesWithTheEigenvalues) {
  for (const LimitCase& limit_case : kLimitCases) {
    const SampledPlant plant =
        ideal(limit_case.mass_kg, limit_case.damping, limit_case.stiffness, 1e-3, std::min(limit_case.delay_s, 0.0205));
    for (const double stiffness : {0.0, 20.0}) {
      const double limit = find_stable_damping(plant, stiffness).value;
      EXPECT_LT(compute_spectral_radius(plant, {stiffness, 0.995 * limit}), 1.0);
      EXPECT_GT(compute_spectral_radius(plant, {stiffness, 1.005 * limit}), 1.0);
    }
  }
}

TEST(StableDamping, DampingInTheWallAllowsMoreStiffness) {
  const SampledPlant plant = ideal(0.225, 5.0, 500.0, 1e-3, 0.0);
  EXPECT_GT(find_stable_stiffness(plant, 10.0).value, find_stable_stiffness(plant, 0.0).value);
}

}  // namespace
}  // namespace hapton
