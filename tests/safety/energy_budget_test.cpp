#include "safety/energy_budget.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

constexpr double kMaxN = 10.0;  // 0.1 J free, 0.3 J at most, 0.02 W forgiven: 2e-5 J in each step of 1 ms

// force_n was on the motors for 1 ms while the device moved by moved_m along z.
void move_with_force(EnergyBudget& budget, double force_n, double moved_m) {
  const Wrench wrench{Vec3(0, 0, force_n), Vec3::Zero()};
  budget.note_applied(wrench, 1e-3);
  budget.observe(kMaxN, wrench, Vec3(0, 0, moved_m), Vec3::Zero());
}

TEST(EnergyBudget, CountsEnergyGivenAndTaken) {
  EnergyBudget budget;
  move_with_force(budget, 5.0, 0.002);
  EXPECT_NEAR(budget.spent_j(), 0.010 - 2e-5, 1e-12);
  move_with_force(budget, -5.0, 0.001);
  EXPECT_NEAR(budget.spent_j(), 0.005 - 4e-5, 1e-12);
}

TEST(EnergyBudget, TakesTheMeanOfTheForcesBetweenTwoSamples) {
  EnergyBudget budget;
  budget.note_applied({Vec3(0, 0, 2), Vec3::Zero()}, 0.75e-3);
  budget.note_applied({Vec3(0, 0, 6), Vec3::Zero()}, 0.25e-3);
  budget.observe(kMaxN, {}, Vec3(0, 0, 0.001), Vec3::Zero());
  EXPECT_NEAR(budget.spent_j(), 0.003 - 2e-5, 1e-12);
}

TEST(EnergyBudget, CountsTorqueAndTurn) {
  EnergyBudget budget;
  budget.note_applied({Vec3::Zero(), Vec3(0, 0.5, 0)}, 1e-3);
  budget.observe(kMaxN, {}, Vec3::Zero(), Vec3(0, 0.1, 0));
  EXPECT_NEAR(budget.spent_j(), 0.05 - 2e-5, 1e-12);
}

TEST(EnergyBudget, WithoutTimeThePresentWrenchDecides) {
  EnergyBudget budget;
  budget.observe(kMaxN, {Vec3(0, 0, 3), Vec3::Zero()}, Vec3(0, 0, 0.01), Vec3::Zero());
  EXPECT_NEAR(budget.spent_j(), 0.03, 1e-12);
}

TEST(EnergyBudget, FreeEnergyIsNeitherDampedNorLimited) {
  EnergyBudget budget;
  move_with_force(budget, 5.0, 0.02);
  ASSERT_LT(budget.spent_j(), EnergyBudget::free_j(kMaxN));
  EXPECT_EQ(budget.damping_n_s_per_m(kMaxN, 0.1, 5.0), 0.0);
  EXPECT_EQ(budget.share(kMaxN), 1.0);
}

TEST(EnergyBudget, DampingTakesTheExcessBackInItsTime) {
  EnergyBudget budget;
  move_with_force(budget, 5.0, 0.021);
  const double excess_j = budget.spent_j() - 0.1;
  ASSERT_GT(excess_j, 0.0);
  const double damping = budget.damping_n_s_per_m(kMaxN, 0.5, 1e3);
  EXPECT_NEAR(damping * 0.5 * 0.5 * EnergyBudget::kTakeBackS, excess_j, 1e-12);
  EXPECT_EQ(budget.damping_n_s_per_m(kMaxN, 0.5, 1e-3), 1e-3);
  EXPECT_EQ(budget.damping_n_s_per_m(kMaxN, 0.0, 5.0), 0.0);
}

TEST(EnergyBudget, TheForceSinksToNothingAndComesBackWithTime) {
  EnergyBudget budget;
  move_with_force(budget, 10.0, 0.02);
  EXPECT_NEAR(budget.share(kMaxN), 0.5, 1e-3);
  move_with_force(budget, 10.0, 0.5);
  EXPECT_EQ(budget.share(kMaxN), 0.0);
  EXPECT_NEAR(budget.spent_j(), 0.36, 1e-12);
  for (int n = 0; n < 13'100; ++n) move_with_force(budget, 0.0, 0.0);  // 0.26 J, at 2e-5 J each
  EXPECT_EQ(budget.share(kMaxN), 1.0);
}

TEST(EnergyBudget, SavesNoMoreThanAPress) {
  EnergyBudget budget;
  for (int n = 0; n < 10'000; ++n) move_with_force(budget, -10.0, 0.001);
  EXPECT_NEAR(budget.spent_j(), -0.1, 1e-12);
}

}  // namespace
}  // namespace hapton
