#include "core/effects/smooth_velocity.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace hapton {
namespace {

constexpr double kMillisecond = 1e-3;

TEST(SmoothVelocity, IsTheVelocityOfSteadyMotion) {
  SmoothVelocity velocity;
  const Vec3 v(0.1, -0.2, 0.05);
  velocity.add(Vec3(1, 2, 3), kMillisecond);
  EXPECT_EQ(velocity.mean(), Vec3::Zero()) << "one sample tells no velocity";
  for (int k = 1; k <= 8; ++k) velocity.add(Vec3(1, 2, 3) + k * kMillisecond * v, kMillisecond);
  EXPECT_LT((velocity.mean() - v).norm(), 1e-12);
  EXPECT_LT((velocity.newest() - v).norm(), 1e-12);
}

// The velocity steps from 0 to 1 m/s: after m of 8 samples the mean is the sum of the first m weights, 8/36, 7/36, 6/36 ...
TEST(SmoothVelocity, WeightsFallLinearly) {
  SmoothVelocity velocity;
  velocity.add(Vec3::Zero(), kMillisecond);
  double weight_sum = 0.0;
  for (int m = 1; m <= 8; ++m) {
    velocity.add(Vec3(m * kMillisecond, 0, 0), kMillisecond);
    weight_sum += (9.0 - m) / 36.0;
    EXPECT_NEAR(velocity.mean().x(), weight_sum, 1e-12) << m;
  }
}

TEST(SmoothVelocity, AMovedFrameIsNoMotion) {
  SmoothVelocity velocity;
  velocity.add(Vec3::Zero(), kMillisecond);
  velocity.move_last(Vec3(5, 0, 0));
  velocity.move_last(Vec3(std::numeric_limits<double>::quiet_NaN(), 0, 0));
  velocity.add(Vec3(5.001, 0, 0), kMillisecond);
  EXPECT_NEAR(velocity.newest().x(), 1.0, 1e-9);
}

TEST(SmoothVelocity, ForgetsAllAfterItsSamples) {
  SmoothVelocity noisy;
  SmoothVelocity fresh;
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto point = [&] { return Vec3(unit(random), unit(random), unit(random)); };
  for (int k = 0; k < 100; ++k) noisy.add(point(), kMillisecond);
  for (int k = 0; k < 9; ++k) {
    const Vec3 p = point();
    noisy.add(p, kMillisecond);
    fresh.add(p, kMillisecond);
  }
  // The sum is in the order of the samples, so both results are the same to the bit.
  EXPECT_EQ(noisy.mean(), fresh.mean());
}

// The sum of v_k . mean_k, to which the energy that a damper takes is proportional, for motions that could make it negative: noise, and
// oscillations of every frequency up to half the sample rate.
TEST(SmoothVelocity, IsAlongTheMotionOverall) {
  constexpr std::uint64_t kSeed = 11;
  RecordProperty("seed", static_cast<int>(kSeed));
  std::mt19937_64 random(kSeed);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 200; ++trial) {
    SmoothVelocity velocity;
    Vec3 p = Vec3::Zero();
    velocity.add(p, kMillisecond);
    double damper_energy = 0.0;
    double sum_of_squares = 0.0;
    for (int k = 0; k < 400; ++k) {
      const double angle = std::numbers::pi * trial / 100.0 * k;
      const Vec3 v = trial <= 100 ? Vec3(std::cos(angle), std::sin(angle), 0) : Vec3(normal(random), normal(random), normal(random));
      p += kMillisecond * v;
      velocity.add(p, kMillisecond);
      damper_energy += velocity.newest().dot(velocity.mean());
      sum_of_squares += velocity.newest().squaredNorm();
    }
    // The filter's response has a real part of at least half its first weight: (8 / 36) / 2.
    EXPECT_GT(damper_energy, 0.99 * sum_of_squares / 9.0) << "trial " << trial << ", seed " << kSeed;
  }
}

// A sample comes 0.9 ms late, the next one 0.1 ms later with an encoder error of 10 um. That error counts 8 times, over 35.1 weighted ms.
TEST(SmoothVelocity, AnIntervalCountsByItsLength) {
  SmoothVelocity velocity;
  double x_m = 0.0;
  velocity.add(Vec3::Zero(), kMillisecond);
  for (int k = 0; k < 8; ++k) velocity.add(Vec3(x_m += 0.1e-3, 0, 0), kMillisecond);
  velocity.add(Vec3(x_m += 0.19e-3, 0, 0), 1.9e-3);
  velocity.add(Vec3(x_m + 0.01e-3 + 1e-5, 0, 0), 0.1e-3);
  EXPECT_NEAR(velocity.newest().x(), 0.2, 1e-9);
  EXPECT_NEAR(velocity.mean().x(), 0.1 + 8 * 1e-5 / 35.1e-3, 1e-12);
}

// The energy that a damper takes where samples come late and early in turn: forward in the long intervals, back in the short ones.
TEST(SmoothVelocity, IsAlongTheMotionAlsoWhereSamplesComeLate) {
  for (const double early_s : {0.1e-3, 0.3e-3, 0.8e-3}) {
    for (double backward_speed = 0.0; backward_speed < 20.0; backward_speed += 0.5) {
      SmoothVelocity velocity;
      Vec3 p = Vec3::Zero();
      velocity.add(p, kMillisecond);
      double damper_energy_j = 0.0;
      for (int k = 0; k < 200; ++k) {
        const double dt_s = k % 2 == 0 ? 2e-3 - early_s : early_s;
        const Vec3 moved = dt_s * Vec3(k % 2 == 0 ? 1.0 : -backward_speed, 0, 0);
        p += moved;
        velocity.add(p, dt_s);
        damper_energy_j += moved.dot(velocity.mean());
      }
      EXPECT_GT(damper_energy_j, 0.0) << early_s << " s, back with " << backward_speed;
    }
  }
}

// An infinite interval has a finite weight, like any other.
TEST(SmoothVelocity, StaysFiniteAfterAnyInterval) {
  for (const double dt_s : {1e-310, 1e-12, 1e6, 1e300, std::numeric_limits<double>::infinity()}) {
    SmoothVelocity velocity;
    velocity.add(Vec3::Zero(), kMillisecond);
    velocity.shift(3, Vec3(0.1, 0, 0));
    EXPECT_TRUE(velocity.mean().allFinite()) << dt_s;
    for (int k = 1; k <= 8; ++k) {
      velocity.add(Vec3(1e-4 * k, 0, 0), k == 4 ? dt_s : kMillisecond);
      EXPECT_TRUE(velocity.mean().allFinite()) << dt_s;
    }
    for (int k = 9; k <= 16; ++k) velocity.add(Vec3(1e-4 * k, 0, 0), kMillisecond);
    EXPECT_NEAR(velocity.mean().x(), 0.1, 1e-9) << dt_s << ": forgotten";
  }
}

TEST(SmoothVelocity, IgnoresInvalidSamples) {
  SmoothVelocity velocity;
  velocity.add(Vec3::Zero(), kMillisecond);
  velocity.add(Vec3(kMillisecond, 0, 0), kMillisecond);
  const Vec3 before = velocity.mean();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  velocity.add(Vec3(nan, 0, 0), kMillisecond);
  velocity.add(Vec3(1, 0, 0), 0.0);
  velocity.add(Vec3(1, 0, 0), -1.0);
  velocity.add(Vec3(1, 0, 0), nan);
  EXPECT_EQ(velocity.mean(), before);
  velocity.add(Vec3(1e308, 0, 0), 1e-300);
  EXPECT_TRUE(velocity.mean().allFinite());
  velocity.reset();
  EXPECT_EQ(velocity.mean(), Vec3::Zero());
  EXPECT_EQ(velocity.newest(), Vec3::Zero());
}

}  // namespace
}  // namespace hapton
