#include "core/math/quadratic.h"

#include <gtest/gtest.h>

#include <random>

namespace hapton {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

// Finds in small steps the first time at which the quadratic is above zero after having been at or below zero.
double scan_for_rise(double a, double b, double c) {
  const auto value = [&](double t) { return (a * t + 2.0 * b) * t + c; };
  for (int i = 1; i <= 400'000; ++i) {
    const double t = 1e-4 * i;
    if (value(t) > 0.0 && value(t - 1e-4) <= 0.0) return t;
  }
  return kNever;
}

TEST(Quadratic, RisesWhereAScanOfItDoes) {
  std::mt19937_64 random(20261121);
  std::uniform_real_distribution<double> coefficient(-1.0, 1.0);
  int risen = 0;
  for (int i = 0; i < 60; ++i) {
    const double a = coefficient(random);
    const double b = coefficient(random);
    const double c = -std::fabs(coefficient(random));
    const double expected = scan_for_rise(a, b, c);
    const double found = time_of_rise(a, b, c);
    if (expected == kNever) {
      EXPECT_GT(found, 39.0) << a << ' ' << b << ' ' << c;  // the scan ends at 40
      continue;
    }
    ++risen;
    EXPECT_NEAR(found, expected, 2e-4) << a << ' ' << b << ' ' << c;
  }
  EXPECT_GT(risen, 20);
}

TEST(Quadratic, FromAboveRisesAtOnceOrAfterItHasFallen) {
  EXPECT_EQ(time_of_rise(1.0, 0.5, 0.0), 0.0);
  EXPECT_EQ(time_of_rise(-1.0, 0.5, 2.0), 0.0);
  EXPECT_EQ(time_of_rise(1.0, -3.0, 5.0), 5.0);  // roots 1 and 5
  EXPECT_EQ(time_of_rise(1.0, -1.0, 5.0), 2.0);  // it stays above zero; at 2 it is back at its first value
  EXPECT_EQ(time_of_rise(-1.0, -1.0, 5.0), kNever);
}

// The maximum of this quadratic is 1 above zero; a play (tolerance) of 1 ignores it.
TEST(Quadratic, ACrestWithinThePlayIsNoRise) {
  EXPECT_EQ(time_of_rise(-1.0, 1.0, 0.0), 0.0);
  EXPECT_EQ(time_of_rise(-1.0, 1.0, 0.0, 1.0), kNever);
  EXPECT_EQ(time_of_rise(-1.0, 1.0, 0.0, 0.5), 0.0);
}

}  // namespace
}  // namespace hapton
