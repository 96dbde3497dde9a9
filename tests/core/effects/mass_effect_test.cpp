#include "core/effects/mass_effect.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <random>

#include "core/effects/smooth_velocity.h"
#include "tests/core/effects/effect_paths.h"

namespace hapton {
namespace {

using Complex = std::complex<double>;

// The hand goes from rest to the speed v at once. The mass follows as u = v (1 - exp(-t / filter)), whatever the length of the steps.
TEST(MassEffect, IsTowedUpToTheSpeedOfTheHand) {
  const MassEffect mass = {.mass_kg = 0.2, .filter_s = 0.03, .max_force_n = 50};
  const Vec3 v(0.1, 0.0, -0.2);
  MassEffect::State state;
  double t_s = 0.0;
  mass.force({.time_s = t_s}, state);
  for (int k = 0; k < 400; ++k) {
    const double dt_s = k % 3 == 0 ? 1e-3 : 0.25e-3;
    const double begin = std::exp(-t_s / mass.filter_s);
    t_s += dt_s;
    const double end = std::exp(-t_s / mass.filter_s);
    const Vec3 force_n = mass.force({.v_SD = v, .time_s = t_s}, state);
    // The mean of m / filter v exp(-t / filter) over the step.
    ASSERT_LT((force_n + mass.mass_kg * (begin - end) / dt_s * v).norm(), 1e-10) << k;
    ASSERT_LT((state.u - (1.0 - end) * v).norm(), 1e-12) << k;
  }
}

TEST(MassEffect, IsTheMassTimesTheAccelerationOfAHandThatSpeedsUpSteadily) {
  const MassEffect mass = {.mass_kg = 0.2, .filter_s = 0.02, .max_force_n = 50};
  const Vec3 a(1.5, -0.5, 0.0);
  MassEffect::State state;
  SmoothVelocity velocity;
  Vec3 force_n = Vec3::Zero();
  for (int k = 0; k <= 600; ++k) {
    const double t_s = 1e-3 * k;
    velocity.add(0.5 * t_s * t_s * a, 1e-3);
    force_n = mass.force({.v_SD = velocity.mean(), .time_s = t_s}, state);
  }
  EXPECT_LT((force_n + 0.2 * a).norm(), 1e-9);
}

// Compared with the sampled form of m s / (1 + filter s), behind the mean of eight differences (SmoothVelocity).
TEST(MassEffect, FollowsASwingingHandAsItsClosedFormDoes) {
  const MassEffect mass = {.mass_kg = 0.1, .filter_s = 0.02, .max_force_n = 50};
  for (const double hz : {0.5, 2.0, 8.0, 30.0, 120.0, 400.0}) {
    const double angle = 2.0 * std::numbers::pi * hz * 1e-3;
    const Complex delay = std::polar(1.0, -angle);
    Complex mean;
    for (int i = 0; i < 8; ++i) mean += (8.0 - i) / 36.0 * std::pow(delay, i);
    const double share = -std::expm1(-1e-3 / 0.02);
    const Complex acceleration = share * (1.0 - delay) / (1.0 - (1.0 - share) * delay) / 1e-3 * mean * (1.0 - delay) / 1e-3;
    MassEffect::State state;
    SmoothVelocity velocity;
    double worst_n = 0.0;
    for (int k = 0; k <= 2000; ++k) {
      velocity.add({1e-3 * std::cos(angle * k), 0, 0}, 1e-3);
      const double force_n = mass.force({.v_SD = velocity.mean(), .time_s = 1e-3 * k}, state).x();
      const double expected_n = -0.1 * 1e-3 * (acceleration * std::polar(1.0, angle * k)).real();
      if (k > 1000) worst_n = std::max(worst_n, std::fabs(force_n - expected_n));
    }
    EXPECT_LT(worst_n, 1e-9 * 0.1 * 1e-3 * std::abs(acceleration)) << hz << " Hz";
    // A slow hand feels the mass.
    if (hz <= 2.0) {
      EXPECT_NEAR(acceleration.real() / -std::pow(2.0 * std::numbers::pi * hz, 2), 1.0, 0.07) << hz << " Hz";
    }
  }
}

TEST(MassEffect, IsBoundedAndThenStillTowed) {
  const MassEffect mass = {.mass_kg = 1.0, .filter_s = 0.01, .max_force_n = 2.0};
  MassEffect::State state;
  for (int k = 0; k <= 100; ++k) {
    EXPECT_LE(mass.force({.v_SD = {0, 3, 4}, .time_s = 1e-3 * k}, state).norm(), 2.0 * (1 + 1e-12));
  }
  EXPECT_NEAR(state.u.norm(), 0.2, 1e-12) << "0.1 s at 2 N and 1 kg";
}

TEST(MassEffect, IsAtRestInItsVolumeUntilTheHandComesAndIsLeftBehind) {
  const MassEffect mass = {.mass_kg = 0.1, .filter_s = 0.02, .volume = EffectVolume::ball(Vec3::Zero(), 0.01)};
  MassEffect::State state;
  const Vec3 outside(0.02, 0, 0);
  const Vec3 v(0.1, 0, 0);
  EXPECT_EQ(mass.force({.p_SD = outside, .v_SD = v, .time_s = 1.0}, state), Vec3::Zero());
  EXPECT_NEAR(mass.force({.v_SD = v, .time_s = 1.001}, state).x(), -0.5, 0.02) << "m v / filter at first";
  EXPECT_GT(state.u.x(), 0.0);
  EXPECT_EQ(mass.force({.p_SD = outside, .v_SD = v, .time_s = 1.002}, state), Vec3::Zero());
  EXPECT_EQ(state.u, Vec3::Zero());
}

TEST(MassEffect, GivesTheSameForceAgainWhereNoTimeHasPassed) {
  const MassEffect mass;
  MassEffect::State state;
  mass.force({.time_s = 0.0}, state);
  const Vec3 force_n = mass.force({.v_SD = {0.1, 0, 0}, .time_s = 1e-3}, state);
  EXPECT_LT(force_n.x(), 0.0);
  EXPECT_EQ(mass.force({.v_SD = {0.3, 0, 0}, .time_s = 1e-3}, state), force_n);
}

// Any motion at equal intervals, of any frequency up to half the sample rate: oscillations, noise, smooth paths.
TEST(MassEffect, NeverGivesEnergyBelowItsBound) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    const MassEffect mass = {.mass_kg = 0.5, .filter_s = seed % 2 == 0 ? 0.005 : 0.2, .max_force_n = 1e9};
    const double angle = std::numbers::pi * static_cast<double>(seed) / 60.0;
    const auto smooth = paths::closed(seed, 1000, Vec3::Zero(), 0.04);
    MassEffect::State state;
    SmoothVelocity velocity;
    double energy_to_hand_j = 0.0;
    double least_j = 0.0;
    Vec3 last = Vec3::Zero();
    velocity.add(last, 1e-3);
    for (int k = 1; k <= 1000; ++k) {
      const Vec3 noise(unit(random), unit(random), unit(random));
      const Vec3 swing(std::cos(angle * k), std::sin(angle * k), 0.0);
      const Vec3 p = seed % 3 == 0 ? Vec3(smooth[static_cast<std::size_t>(k % 1000)] - smooth[0]) : Vec3(1e-3 * swing + 1e-5 * noise);
      velocity.add(p, 1e-3);
      energy_to_hand_j += mass.force({.p_SD = p, .v_SD = velocity.mean(), .time_s = 1e-3 * k}, state).dot(p - last);
      least_j = std::min(least_j, energy_to_hand_j);
      last = p;
      ASSERT_LE(energy_to_hand_j, -1e-12 * least_j) << "seed " << seed << ", step " << k;
    }
    EXPECT_LT(energy_to_hand_j, 0.0) << "seed " << seed;
  }
}

// With the velocity of the last interval, the energy balance in mass_effect.h holds at any intervals, and also where the damper slips.
TEST(MassEffect, WithTheLastIntervalsVelocityGivesNoEnergy) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const MassEffect mass = {.mass_kg = 0.5, .filter_s = 0.01, .max_force_n = 25.0};
  MassEffect::State state;
  double t_s = 0.0;
  double energy_to_hand_j = 0.0;
  int slips = 0;
  for (int k = 0; k < 5000; ++k) {
    const double dt_s = std::pow(10.0, -3.0 + unit(random));
    t_s += dt_s;
    const Vec3 v(unit(random), unit(random), 0.2);
    const Vec3 force_n = mass.force({.v_SD = v, .time_s = t_s}, state);
    slips += force_n.norm() > 24.99 ? 1 : 0;
    energy_to_hand_j += dt_s * force_n.dot(v);
    ASSERT_LE(energy_to_hand_j, -0.5 * 0.5 * state.u.squaredNorm() + 1e-12) << "step " << k;
  }
  EXPECT_GT(slips, 1000);
  EXPECT_LT(slips, 4900);
}

}  // namespace
}  // namespace hapton
