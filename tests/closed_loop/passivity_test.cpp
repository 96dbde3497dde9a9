#include "closed_loop/passivity.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <random>

#include "closed_loop/stability.h"

namespace hapton {
namespace {

double viscous_limit(const PassivityCase& loop) { return find_passive_stiffness(loop).viscous_n_per_m; }

// The condition of Colgate and Schenkel: b > K T / 2 + |B|, with the damping b of the device and B of the wall.
TEST(PassiveStiffness, OfASpringAndDamperIsColgateAndSchenkels) {
  for (const double b : {0.1, 1.0, 5.5}) {
    EXPECT_NEAR(viscous_limit({.period_s = 1e-3, .damping_ns_per_m = b}), 2e3 * b, 2e-6 * 2e3 * b);
    EXPECT_NEAR(viscous_limit({.period_s = 2.5e-4, .damping_ns_per_m = b, .wall_damping_ns_per_m = 0.4 * b}), 8e3 * 0.6 * b,
                2e-6 * 8e3 * b);
  }
  EXPECT_EQ(viscous_limit({.damping_ns_per_m = 1.0, .wall_damping_ns_per_m = 1.0}), 0.0);
  EXPECT_EQ(viscous_limit({.damping_ns_per_m = 0.0}), 0.0);
}

TEST(PassiveStiffness, WithDelayIsAboutTheLinearRuleOfTheDevice) {
  for (const double delay_s : {1e-3, 7e-3, 0.1, 0.5}) {
    EXPECT_NEAR(viscous_limit({.delay_s = delay_s, .damping_ns_per_m = 2.0}), 2.0 / (0.5e-3 + delay_s), 1e-5 * 2.0 / delay_s);
  }
}

// The largest stiffness by the condition as the paper prints it, for whole periods of delay, on a grid of frequencies.
double by_the_papers_condition(double b, double period_s, int periods, double wall_damping) {
  const auto holds = [&](double stiffness) {
    for (int i = 1; i <= 20'000; ++i) {
      const double angle = std::numbers::pi * i / 20'000;
      const std::complex<double> z = std::polar(1.0, angle);
      const std::complex<double> wall = (stiffness + wall_damping * (z - 1.0) / (period_s * z)) * std::pow(z, -periods);
      const double needed_damping = 0.5 * period_s / (1.0 - std::cos(angle)) * std::real((1.0 - 1.0 / z) * wall);
      if (needed_damping >= b) return false;
    }
    return true;
  };
  double low = 0.0;
  double high = 4.0 * b / period_s;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (holds(middle) ? low : high) = middle;
  }
  return low;
}

TEST(PassiveStiffness, IsTheConditionOfThePaper) {
  EXPECT_NEAR(viscous_limit({.delay_s = 3e-3, .damping_ns_per_m = 2.0}), by_the_papers_condition(2.0, 1e-3, 3, 0.0), 0.01);
  const double with_damping = by_the_papers_condition(2.0, 1e-3, 2, 0.3);
  EXPECT_NEAR(viscous_limit({.delay_s = 2e-3, .damping_ns_per_m = 2.0, .wall_damping_ns_per_m = 0.3}), with_damping, 1e-3 * with_damping);
}

// A wall within the passive limit is stable in every hand, whatever its mass, spring and damper: the limit of stability is not lower.
TEST(PassiveStiffness, IsStableWithEveryHand) {
  constexpr std::uint64_t kSeed = 3;
  std::mt19937_64 random(kSeed);
  const auto by_ratio = [&](double low, double high) {
    return low * std::pow(high / low, std::uniform_real_distribution<double>(0.0, 1.0)(random));
  };
  for (int i = 0; i < 200; ++i) {
    const DeviceModel device{.mass_kg = by_ratio(0.02, 0.5), .damping_ns_per_m = by_ratio(0.05, 5.0)};
    const HandModel hand{by_ratio(1e-3, 5.0), by_ratio(1e-3, 20.0), by_ratio(1.0, 1e5)};
    const double delay_s = 1e-3 * std::uniform_real_distribution<double>(0.0, 20.0)(random);
    const double passive = viscous_limit({.delay_s = delay_s, .damping_ns_per_m = device.damping_ns_per_m});
    const SampledPlant plant(make_axis_plant(device, hand), 1e-3, delay_s);
    EXPECT_GE(find_stable_stiffness(plant, 0.0).value, passive) << "seed " << kSeed << ", hand " << i;
  }
}

TEST(PassiveStiffness, ALagOfTheAmplifierCountsAsDelayOfSlowMotions) {
  const double with_lag = viscous_limit({.damping_ns_per_m = 2.0, .amplifier_s = 5e-4});
  EXPECT_LT(with_lag, viscous_limit({.damping_ns_per_m = 2.0}));
  EXPECT_LE(with_lag, 2.0 / (0.5e-3 + 0.5e-3) * (1.0 + 1e-9));
}

// The passive limit by its definition, for a spring alone without delay, on a grid of frequencies: the least stiffness K for which 1 + K
// times the sum over all aliases of a frequency, added term by term, can be zero in some passive hand.
double by_the_sum_of_aliases(double b, double period_s, double amplifier_s) {
  constexpr int kTerms = 100'000;
  double least = std::numeric_limits<double>::infinity();
  for (int i = 1; i <= 60; ++i) {
    const double angle = std::numbers::pi * i / 60.0;
    const std::complex<double> difference = 1.0 - std::polar(1.0, -angle);
    std::complex<double> centre;
    double radius = 0.0;
    for (int n = -kTerms; n <= kTerms; ++n) {
      const std::complex<double> jw(0.0, (angle + 2.0 * std::numbers::pi * n) / period_s);
      // Hold, lag and integration of a velocity; the admittance of hand and device lies in the disk of radius 1 / 2b about 1 / 2b.
      const std::complex<double> weight = difference / (jw * jw * period_s * (1.0 + jw * amplifier_s)) / (2.0 * b);
      centre += weight;
      radius += std::abs(weight);
    }
    const auto stays_clear = [&](double stiffness) { return std::abs(1.0 + stiffness * centre) > stiffness * radius; };
    double low = 0.0;
    double high = 4.0 * b / period_s;
    for (int k = 0; k < 50; ++k) {
      const double middle = 0.5 * (low + high);
      (stays_clear(middle) ? low : high) = middle;
    }
    least = std::min(least, low);
  }
  return least;
}

TEST(PassiveStiffness, WithAnAmplifierIsThatOfTheSumOfAllAliases) {
  for (const double amplifier_s : {1e-4, 5e-4}) {
    const double limit = viscous_limit({.damping_ns_per_m = 2.0, .amplifier_s = amplifier_s});
    const double by_definition = by_the_sum_of_aliases(2.0, 1e-3, amplifier_s);
    EXPECT_LE(limit, by_definition * (1.0 + 1e-6)) << amplifier_s << ": the grid may miss the least";
    EXPECT_GE(limit, 0.9 * by_definition) << amplifier_s;
  }
}

// Source: Abbott and Okamura 2005.
TEST(PassiveStiffness, WithEncoderStepsNeedsFriction) {
  const PassiveStiffness both = find_passive_stiffness({.damping_ns_per_m = 10.0, .friction_n = 0.04, .encoder_step_m = 3e-5});
  EXPECT_DOUBLE_EQ(both.quantised_n_per_m, 2.0 * 0.04 / 3e-5);
  EXPECT_EQ(both.least_n_per_m(), both.quantised_n_per_m);
  EXPECT_EQ(find_passive_stiffness({.damping_ns_per_m = 10.0, .encoder_step_m = 3e-5}).least_n_per_m(), 0.0);
  EXPECT_TRUE(std::isinf(find_passive_stiffness({.damping_ns_per_m = 10.0, .friction_n = 0.04}).quantised_n_per_m));
}

// The condition of the paper holds just below the damping of the device at any delay of whole periods, and fails just above it.
TEST(PassiveDamping, IsTheDevicesOwn) {
  const double b = passive_damping_ns_per_m({.damping_ns_per_m = 2.0});
  EXPECT_EQ(b, 2.0);
  for (const int periods : {0, 1, 2, 7}) {
    EXPECT_GT(by_the_papers_condition(2.0, 1e-3, periods, 0.99 * b), 0.0) << periods;
    EXPECT_LT(by_the_papers_condition(2.0, 1e-3, periods, 1.01 * b), 1e-6) << periods;
  }
}

TEST(LinearRule, IsSevenTimesOffAt100Ms) {
  const SampledPlant plant(make_axis_plant({.mass_kg = 0.225, .damping_ns_per_m = 5.0}, {.stiffness_n_per_m = 500.0}), 1e-3, 0.1);
  EXPECT_GT(find_stable_stiffness(plant, 0.0).value / linear_rule_n_per_m(5.0, 1e-3, 0.1), 7.0);
}

}  // namespace
}  // namespace hapton
