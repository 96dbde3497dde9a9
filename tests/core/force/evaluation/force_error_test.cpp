#include "core/force/evaluation/force_error.h"

#include <gtest/gtest.h>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace hapton {
namespace {

constexpr double kStiffness = 1000.0;

// The device slides 0.1 mm a step, 1 mm below a plane; the proxy is above it on the plane.
std::vector<ForceSample> slide(std::size_t n) {
  std::vector<ForceSample> steps(n);
  for (std::size_t i = 0; i < n; ++i) {
    steps[i].device = Vec3(1e-4 * static_cast<double>(i), 0.0, -1e-3);
    steps[i].proxy = Vec3(1e-4 * static_cast<double>(i), 0.0, 0.0);
    steps[i].force_n = kStiffness * (steps[i].proxy - steps[i].device);
  }
  return steps;
}

void put_proxy(ForceSample& step, const Vec3& proxy) {
  step.proxy = proxy;
  step.force_n = kStiffness * (proxy - step.device);
}

TEST(ForceError, NothingToSayWhenAllAgree) {
  const auto steps = slide(100);
  const ForceError error = compare_forces(steps, steps, {});
  EXPECT_EQ(error.steps, 100u);
  EXPECT_EQ(error.contact_steps, 100u);
  EXPECT_EQ(error.error.rms, 0.0);
  EXPECT_EQ(error.fall_throughs + error.false_contacts + error.stuck_steps + error.discontinuities + error.branch_switches +
                error.unsettled_steps + error.not_finite,
            0u);
}

TEST(ForceError, MeasuresSizeAndDirection) {
  const auto reference = slide(200);
  auto method = reference;
  for (ForceSample& step : method) put_proxy(step, step.proxy + Vec3(0.0, 1e-5, 0.0));  // 1 % aside
  const ForceError error = compare_forces(method, reference, {});
  EXPECT_NEAR(error.error.rms, 0.01, 1e-12);
  EXPECT_NEAR(error.error.p50, 0.01, 1e-12);
  EXPECT_NEAR(error.direction_rad.p99, std::atan(0.01), 1e-12);
  EXPECT_EQ(error.discontinuities, 0u);
}

TEST(ForceError, EveryStepOfABranchSwitchIsAnError) {
  const auto reference = slide(100);
  auto method = reference;
  for (std::size_t i = 40; i < 50; ++i) put_proxy(method[i], method[i].proxy + Vec3(0.0, 1e-3, 0.0));
  put_proxy(method[70], method[70].proxy + Vec3(0.0, 1e-3, 0.0));
  put_proxy(method[80], method[80].proxy + Vec3(0.0, 9e-6, 0.0));  // 0.9 %: an error, no switch
  const ForceError error = compare_forces(method, reference, {});
  EXPECT_EQ(error.branch_switches, 2u);
  EXPECT_EQ(error.switched_steps, 11u);
  EXPECT_EQ(error.error.count, 100u);
  EXPECT_NEAR(error.error.most, 1.0, 1e-12);
  EXPECT_NEAR(error.error.rms, std::sqrt((11.0 + 81e-6) / 100.0), 1e-12);
  EXPECT_EQ(error.worst_step, 40u);
}

TEST(ForceError, AResetEndsABranchSwitch) {
  const auto reference = slide(100);
  auto method = reference;
  for (std::size_t i = 40; i < 60; ++i) put_proxy(method[i], method[i].proxy + Vec3(0.0, 1e-3, 0.0));
  EXPECT_EQ(compare_forces(method, reference, {}).branch_switches, 1u);
  EXPECT_EQ(compare_forces(method, reference, {.reset_every = 50}).branch_switches, 2u);
}

TEST(ForceError, UnsettledStepsCountAndAreCounted) {
  auto reference = slide(100);
  reference[40].settled = false;
  auto method = reference;
  put_proxy(method[40], method[40].proxy + Vec3(0.0, 1e-3, 0.0));
  const ForceError error = compare_forces(method, reference, {});
  EXPECT_EQ(error.unsettled_steps, 1u);
  EXPECT_NEAR(error.error.most, 1.0, 1e-12);
}

TEST(ForceError, FallThroughsAndFalseContacts) {
  const auto pressed = slide(50);
  auto free = pressed;
  for (ForceSample& step : free) put_proxy(step, step.device);
  EXPECT_EQ(compare_forces(free, pressed, {}).fall_throughs, 50u);
  EXPECT_EQ(compare_forces(pressed, free, {}).false_contacts, 50u);
  // Shallower than 0.25 % of the extent is neither.
  EXPECT_EQ(compare_forces(free, pressed, {.extent_m = 1.0}).fall_throughs, 0u);
  EXPECT_EQ(compare_forces(free, pressed, {}).contact_steps, 50u);
}

TEST(ForceError, AProxyLeftBehindIsStuck) {
  const auto reference = slide(300);
  auto method = reference;
  for (std::size_t i = 100; i < 300; ++i) put_proxy(method[i], method[100].proxy);  // 20 mm behind at the end
  const ForceError error = compare_forces(method, reference, {});
  EXPECT_GT(error.stuck_steps, 80u);
  EXPECT_LT(error.stuck_steps, 110u);
  EXPECT_EQ(error.discontinuities, 0u);
}

TEST(ForceError, ADiscontinuityIsAJumpThatTheReferenceDoesNotMake) {
  const auto reference = slide(100);
  auto method = reference;
  for (std::size_t i = 50; i < 100; ++i) put_proxy(method[i], method[i].proxy + Vec3(0.0, 5e-4, 0.0));
  const ForceError error = compare_forces(method, reference, {});
  EXPECT_EQ(error.discontinuities, 1u);
  EXPECT_NEAR(error.worst_discontinuity_n, 0.5 - 0.2, 1e-9);
  EXPECT_EQ(compare_forces(method, reference, {.reset_every = 50}).discontinuities, 0u);  // the jump falls on a reset
}

TEST(ForceError, NotFiniteIsCountedAndLeftOut) {
  const auto reference = slide(10);
  auto method = reference;
  method[3].force_n.x() = std::numeric_limits<double>::quiet_NaN();
  const ForceError error = compare_forces(method, reference, {});
  EXPECT_EQ(error.not_finite, 1u);
  EXPECT_EQ(error.error.count, 9u);
  EXPECT_EQ(error.error.rms, 0.0);
}

TEST(ErrorSpread, NearestRank) {
  std::vector<double> values;
  for (int i = 1; i <= 100; ++i) values.push_back(i);
  const ErrorSpread spread = spread_of(values);
  EXPECT_EQ(spread.p50, 50.0);
  EXPECT_EQ(spread.p99, 99.0);
  EXPECT_EQ(spread.most, 100.0);
  EXPECT_NEAR(spread.rms, std::sqrt(338350.0 / 100.0), 1e-12);
  EXPECT_EQ(spread_of({}).count, 0u);
}

}  // namespace
}  // namespace hapton
