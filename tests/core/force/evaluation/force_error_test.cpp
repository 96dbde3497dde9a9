#include "core/force/evaluation/force_error.h"

#include <gtest/gtest.h>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace hapton {
namespace {

constexpr double kComparedStiffness = 1000.0;

// The device slides 0.1 mm a step, 1 mm below a plane; the proxy is above it on the plane.
std::vector<ForceSample> slide(std::size_t n) {
  std::vector<ForceSample> steps(n);
  for (std::size_t i = 0; i < n; ++i) {
    steps[i].device = Vec3(1e-4 * static_cast<double>(i), 0.0, -1e-3);
    steps[i].proxy = Vec3(1e-4 * static_cast<double>(i), 0.0, 0.0);
    steps[i].force_n = kComparedStiffness * (steps[i].proxy - steps[i].device);
  }
  return steps;
}

void put_proxy(ForceSample& step, const Vec3& proxy) {
  step.proxy = proxy;
  step.force_n = kComparedStiffness * (proxy - step.device);
}

TEST(ForceError, IsZeroWhenAllStepsAgree) {
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
  put_proxy(method[80], method[80].proxy + Vec3(0.0, 9e-6, 0.0));  // 0.9 %: an error, but no branch switch
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

TEST(ForceError, UnsettledStepsAreErrorsTooAndAreCounted) {
  auto reference = slide(100);
  reference[40].settled = false;
  auto method = reference;
  put_proxy(method[40], method[40].proxy + Vec3(0.0, 1e-3, 0.0));
  const ForceError error = compare_forces(method, reference, {});
  EXPECT_EQ(error.unsettled_steps, 1u);
  EXPECT_NEAR(error.error.most, 1.0, 1e-12);
}

TEST(ForceError, EveryBranchSwitchHasACause) {
  auto reference = slide(100);
  reference[30].settled = false;
  reference[51].settled = false;  // not where the episode begins
  auto method = reference;
  const auto move_aside = [](std::vector<ForceSample>& steps, std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) put_proxy(steps[i], steps[i].proxy + Vec3(0.0, 1e-3, 0.0));
  };
  move_aside(method, 10, 13);
  move_aside(method, 30, 32);
  move_aside(method, 50, 55);
  move_aside(method, 70, 74);
  auto converged = method;
  put_proxy(converged[10], reference[10].proxy);
  put_proxy(converged[11], reference[11].proxy + Vec3(0.0, 9e-6, 0.0));  // 0.9 %: no branch switch
  put_proxy(converged[12], reference[12].proxy);
  put_proxy(converged[70], reference[70].proxy);  // the other three steps of this branch switch remain
  const ForceError error = compare_forces(method, reference, {}, converged);
  ASSERT_EQ(error.switches.size(), 4u);
  using Cause = BranchSwitch::Cause;
  const Cause causes[] = {Cause::unconverged, Cause::unsettled, Cause::unexplained, Cause::unexplained};
  const std::size_t first[] = {10, 30, 50, 70}, steps[] = {3, 2, 5, 4};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(error.switches[i].cause, causes[i]) << i;
    EXPECT_EQ(error.switches[i].first_step, first[i]);
    EXPECT_EQ(error.switches[i].steps, steps[i]);
    EXPECT_NEAR(error.switches[i].most, 1.0, 1e-12);
  }
  EXPECT_EQ(error.count(Cause::unexplained), 2u);
  EXPECT_EQ(error.branch_switches, 4u);
  // The converged forces do not change what counts as an error.
  const ForceError alone = compare_forces(method, reference, {});
  EXPECT_EQ(alone.error.rms, error.error.rms);
  EXPECT_EQ(alone.switched_steps, error.switched_steps);
  EXPECT_EQ(alone.count(Cause::unconverged), 0u);
  EXPECT_EQ(alone.count(Cause::unsettled), 1u);
}

TEST(ForceError, AllKindsOfFaultAreCounted) {
  ForceError error;
  error.fall_throughs = 1;
  error.false_contacts = 10;
  error.stuck_steps = 100;
  error.discontinuities = 1000;
  error.not_finite = 10000;
  EXPECT_EQ(error.faults(), 11111u);
}

TEST(ForceError, CountsFallThroughsAndFalseContacts) {
  const auto pressed = slide(50);
  auto free = pressed;
  for (ForceSample& step : free) put_proxy(step, step.device);
  EXPECT_EQ(compare_forces(free, pressed, {}).fall_throughs, 50u);
  EXPECT_EQ(compare_forces(pressed, free, {}).false_contacts, 50u);
  // A penetration of less than 0.25 % of the extent counts as neither.
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

TEST(ForceError, AForceThatIsNotFiniteIsCountedAndLeftOut) {
  const auto reference = slide(10);
  auto method = reference;
  method[3].force_n.x() = std::numeric_limits<double>::quiet_NaN();
  const ForceError error = compare_forces(method, reference, {});
  EXPECT_EQ(error.not_finite, 1u);
  EXPECT_EQ(error.error.count, 9u);
  EXPECT_EQ(error.error.rms, 0.0);
}

TEST(ErrorSpread, QuantilesAreOfTheNearestRank) {
  std::vector<double> values;
  for (int i = 1; i <= 100; ++i) values.push_back(i);
  const ErrorSpread spread = spread_of(values);
  EXPECT_EQ(spread.p50, 50.0);
  EXPECT_EQ(spread.p99, 99.0);
  EXPECT_EQ(spread.most, 100.0);
  EXPECT_NEAR(spread.rms, std::sqrt(338350.0 / 100.0), 1e-12);  // the sum of the squares of 1 to 100
  EXPECT_EQ(spread_of({}).count, 0u);
}

}  // namespace
}  // namespace hapton
