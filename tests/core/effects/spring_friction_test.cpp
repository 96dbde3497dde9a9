#include "core/effects/spring_friction.h"

#include <gtest/gtest.h>

#include <random>

namespace hapton {
namespace {

constexpr double kSlipSpring = 800.0;

TEST(SpringFriction, SticksLikeASpringAndSlidesOnTheCone) {
  SpringFriction::State state;
  const Vec3 normal = Vec3::UnitZ();
  // The normal force is 2 N and the coefficient 0.5: it slips at 1 N, when the spring is pulled by 1.25 mm.
  for (int n = 1; n <= 12; ++n) {
    const Vec3 force_n = SpringFriction::force({1e-4, 0, 0}, normal, kSlipSpring, 2.0, {0.5, 0.5}, state);
    EXPECT_LT((force_n - Vec3(-0.08 * n, 0, 0)).norm(), 1e-12) << n;
  }
  for (int n = 0; n < 50; ++n) {
    const Vec3 force_n = SpringFriction::force({1e-4, 0, 3e-5}, normal, kSlipSpring, 2.0, {0.5, 0.5}, state);
    EXPECT_LT((force_n - Vec3(-1.0, 0, 0)).norm(), 1e-12);
  }
  // Where friction is lower it slips at once; where there is none, no force is left.
  EXPECT_NEAR(SpringFriction::force({1e-4, 0, 0}, normal, kSlipSpring, 2.0, {0.1, 0.1}, state).x(), -0.2, 1e-12);
  EXPECT_EQ(SpringFriction::force({1e-4, 0, 0}, normal, kSlipSpring, 2.0, {0.0, 0.0}, state), Vec3(0, 0, 0));
  EXPECT_EQ(state.extension, Vec3(0, 0, 0));
}

// Normal, normal force and coefficient change at random: the hand never gets more than it gave.
TEST(SpringFriction, TakesEnergyOverAnyMotion) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(-1, 1);
    SpringFriction::State state;
    double energy_to_hand_j = 0.0;
    double largest_n = 0.0;
    for (int n = 0; n < 20000; ++n) {
      const Vec3 motion = 2e-4 * Vec3(unit(random), unit(random), unit(random));
      const Vec3 normal = Vec3(0.3 * unit(random), 0.3 * unit(random), 1.0).normalized();
      const double normal_n = 1.0 + unit(random);
      const double coefficient = 0.5 + 0.5 * unit(random);
      const double sliding_coefficient = coefficient * (0.5 + 0.5 * unit(random));
      const Vec3 force_n = SpringFriction::force(motion, normal, kSlipSpring, normal_n, {coefficient, sliding_coefficient}, state);
      EXPECT_LE(force_n.norm(), coefficient * normal_n * (1.0 + 1e-12));
      EXPECT_LT(std::abs(force_n.dot(normal)), 1e-12);
      energy_to_hand_j += force_n.dot(motion);
      largest_n = std::max(largest_n, force_n.norm());
      ASSERT_LE(energy_to_hand_j, 1e-15) << "seed " << seed << ", step " << n;
    }
    EXPECT_GT(largest_n, 0.5);
  }
}

// With a normal force of 2 N it sticks up to 1.6 N, slips at 0.8 N, also after the motion has reversed, and sticks again below 0.4 N.
TEST(SpringFriction, SticksWithTheCoefficientAtRestAndSlipsWithTheOther) {
  SpringFriction::State state;
  const auto move = [&](double x_m) { return SpringFriction::force({x_m, 0, 0}, Vec3::UnitZ(), kSlipSpring, 2.0, {0.8, 0.4}, state).x(); };
  for (int n = 1; n <= 19; ++n) EXPECT_NEAR(move(1e-4), -0.08 * n, 1e-12) << n;
  EXPECT_FALSE(state.slips);
  EXPECT_NEAR(move(2e-4), -0.8, 1e-12);
  for (int n = 0; n < 10; ++n) EXPECT_NEAR(move(1e-4), -0.8, 1e-12);
  EXPECT_NEAR(move(-4e-4), -0.48, 1e-12);
  EXPECT_TRUE(state.slips) << "still";
  EXPECT_NEAR(move(6e-4), -0.8, 1e-12) << "0.96 N without slipping";
  EXPECT_NEAR(move(-6e-4), -0.32, 1e-12);
  EXPECT_FALSE(state.slips);
  EXPECT_NEAR(move(13e-4), -1.36, 1e-12) << "it sticks";
}

}  // namespace
}  // namespace hapton
