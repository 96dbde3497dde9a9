#include "safety/thermal_budget.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

const DeviceLimits kLimits{.max_force_n = 8.0, .max_slew_n_per_s = 1e4, .continuous_force_n = 2.0, .peak_s = 5.0};

TEST(ThermalBudget, BearsThePeakForAsLongAsTheDeviceSays) {
  ThermalBudget budget(kLimits);
  for (int n = 0; n < 5000; ++n) budget.note_applied(Vec3(0, 8, 0), 1e-3);
  EXPECT_NEAR(budget.load(kLimits), 1.0, 1e-9);
}

TEST(ThermalBudget, AllowsTheContinuousForceIndefinitely) {
  ThermalBudget budget(kLimits);
  for (int n = 0; n < 100'000; ++n) budget.note_applied(Vec3(0, 0, 2), 0.01);
  EXPECT_NEAR(budget.load(kLimits), 1.0, 1e-4);
  EXPECT_LE(budget.load(kLimits), 1.0 + 1e-9);
  EXPECT_GE(budget.allowed_n(kLimits), 2.0 - 1e-9);
}

TEST(ThermalBudget, DoesNotDependOnHowTimeIsCut) {
  ThermalBudget fine(kLimits);
  ThermalBudget coarse(kLimits);
  for (int n = 0; n < 30'000; ++n) fine.note_applied(Vec3(4, 0, 0), 1e-4);
  for (int n = 0; n < 6; ++n) coarse.note_applied(Vec3(4, 0, 0), 0.5);
  EXPECT_NEAR(fine.load(kLimits), coarse.load(kLimits), 1e-7);
}

TEST(ThermalBudget, TheForceLimitFallsFromThePeakToTheContinuousForce) {
  ThermalBudget budget(kLimits);
  EXPECT_EQ(budget.allowed_n(kLimits), 8.0);
  double before = 8.0;
  for (int n = 0; n < 6000; ++n) {
    budget.note_applied(Vec3(0, 0, 8), 1e-3);
    ASSERT_LE(budget.allowed_n(kLimits), before);
    ASSERT_GE(budget.allowed_n(kLimits), 2.0);
    ASSERT_GT(budget.allowed_n(kLimits), before - 0.3);
    before = budget.allowed_n(kLimits);
  }
  EXPECT_EQ(before, 2.0);
}

TEST(ThermalBudget, CountsNoMoreThanASecondOfAGap) {
  ThermalBudget budget(kLimits);
  budget.note_applied(Vec3(0, 0, 8), 3600.0);
  ThermalBudget after_a_second(kLimits);
  after_a_second.note_applied(Vec3(0, 0, 8), 1.0);
  EXPECT_EQ(budget.load(kLimits), after_a_second.load(kLimits));
}

TEST(ThermalBudget, ADeviceThatBearsEverythingHasNoThermalLimit) {
  for (const DeviceLimits& limits : {DeviceLimits{.max_force_n = 8.0, .max_slew_n_per_s = 1.0, .continuous_force_n = 8.0, .peak_s = 5.0},
                                     DeviceLimits{.max_force_n = 8.0, .max_slew_n_per_s = 1.0, .continuous_force_n = 2.0, .peak_s = 0.0}}) {
    ThermalBudget budget(limits);
    budget.note_applied(Vec3(0, 0, 8), 1.0);
    EXPECT_EQ(budget.load(limits), 0.0);
    EXPECT_EQ(budget.allowed_n(limits), 8.0);
  }
}

}  // namespace
}  // namespace hapton
