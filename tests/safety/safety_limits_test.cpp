#include "safety/safety_limits.h"

#include <gtest/gtest.h>

#include <limits>
#include <utility>
#include <vector>

#include "tools/governor/hostile_program.h"

namespace hapton {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

DeviceLimits all_limits() {
  return {.max_force_n = 8.0,
          .max_slew_n_per_s = 2000.0,
          .max_stiffness_n_per_m = 1000.0,
          .workspace_min_m = Vec3::Constant(-0.1),
          .workspace_max_m = Vec3::Constant(0.1),
          .max_torque_nm = 0.5,
          .max_torque_slew_nm_per_s = 100.0,
          .continuous_force_n = 2.0,
          .peak_s = 10.0,
          .max_speed_m_per_s = 3.0};
}

// Each field that is a limit; a test sets one of them alone.
const std::vector<double DeviceLimits::*> kFields = {&DeviceLimits::max_force_n,        &DeviceLimits::max_slew_n_per_s,
                                                     &DeviceLimits::max_torque_nm,      &DeviceLimits::max_torque_slew_nm_per_s,
                                                     &DeviceLimits::continuous_force_n, &DeviceLimits::max_speed_m_per_s};

void expect_no_looser(const DeviceLimits& after, const DeviceLimits& before) {
  for (const auto field : kFields) EXPECT_LE(after.*field, before.*field);
  EXPECT_EQ(after.max_stiffness_n_per_m, before.max_stiffness_n_per_m);
  EXPECT_EQ(after.peak_s, before.peak_s);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_GE(after.workspace_min_m[axis], before.workspace_min_m[axis]);
    EXPECT_LE(after.workspace_max_m[axis], before.workspace_max_m[axis]);
    EXPECT_LT(after.workspace_min_m[axis], after.workspace_max_m[axis]);
  }
}

TEST(SafetyLimits, EveryFieldCanBeTightenedAndNoneLoosened) {
  for (const auto field : kFields) {
    SafetyLimits limits(all_limits());
    const double own = limits.current().*field;
    for (const double bad_value : {2.0 * own, 1e8, 1e300, kInf, kNan, -kInf, 0.0, -1.0, 5e-324}) {
      DeviceLimits wanted;
      wanted.*field = bad_value;
      limits.tighten(wanted);
      ASSERT_EQ(limits.current().*field, own) << bad_value;
    }
    DeviceLimits wanted;
    wanted.*field = 0.5 * own;
    limits.tighten(wanted);
    EXPECT_EQ(limits.current().*field, 0.5 * own);
    EXPECT_EQ(limits.device().*field, own);
    wanted.*field = 0.7 * own;
    limits.tighten(wanted);
    EXPECT_EQ(limits.current().*field, 0.5 * own);
    // The others are as they were.
    for (const auto other : kFields) {
      if (other != field) {
        EXPECT_EQ(limits.current().*other, SafetyLimits(all_limits()).current().*other);
      }
    }
  }
}

TEST(SafetyLimits, WorkspacesShrinkToWhatBothHave) {
  SafetyLimits limits(all_limits());
  DeviceLimits wanted;
  wanted.workspace_min_m = Vec3(-0.05, -1.0, 0.5);
  wanted.workspace_max_m = Vec3(1.0, 0.02, 0.6);
  limits.tighten(wanted);
  EXPECT_EQ(limits.current().workspace_min_m, Vec3(-0.05, -0.1, -0.1));
  EXPECT_EQ(limits.current().workspace_max_m, Vec3(0.1, 0.02, 0.1));  // z: the two ranges have nothing in common
}

// An axis whose wanted range is empty, reversed, not a number or outside stays as it is; the other axes shrink.
TEST(SafetyLimits, AnAxisThatMakesNoSenseIsNotShrunk) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const auto& [low, high] : {std::pair(0.05, 0.05), std::pair(0.05, -0.05), std::pair(kNan, 0.05), std::pair(-0.05, kNan),
                                    std::pair(kNan, kNan), std::pair(0.1, 0.2), std::pair(-0.2, -0.1)}) {
      SafetyLimits limits(all_limits());
      DeviceLimits wanted;
      wanted.workspace_min_m = Vec3::Constant(-0.05);
      wanted.workspace_max_m = Vec3::Constant(0.06);
      wanted.workspace_min_m[axis] = low;
      wanted.workspace_max_m[axis] = high;
      limits.tighten(wanted);
      for (int other = 0; other < 3; ++other) {
        EXPECT_EQ(limits.current().workspace_min_m[other], other == axis ? -0.1 : -0.05) << low << " to " << high;
        EXPECT_EQ(limits.current().workspace_max_m[other], other == axis ? 0.1 : 0.06) << low << " to " << high;
      }
    }
  }
}

// Above 1e-9 and below 1e9: a value beyond these is not taken as the limit of a device.
TEST(SafetyLimits, AUsableLimitIsBetweenTheBounds) {
  for (const auto& [max_force_n, is_usable] :
       {std::pair(1e-9, false), std::pair(1.1e-9, true), std::pair(1e9, false), std::pair(0.9e9, true)}) {
    DeviceLimits device = all_limits();
    device.max_force_n = max_force_n;
    EXPECT_EQ(SafetyLimits(device).current().max_force_n, is_usable ? max_force_n : 0.0);
  }
  DeviceLimits device = all_limits();
  device.max_stiffness_n_per_m = kNan;
  EXPECT_EQ(SafetyLimits(device).current().max_stiffness_n_per_m, 0.0);
  device.max_stiffness_n_per_m = 300.0;
  EXPECT_EQ(SafetyLimits(device).current().max_stiffness_n_per_m, 300.0);
  device.continuous_force_n = 9.0;
  EXPECT_EQ(SafetyLimits(device).current().continuous_force_n, 8.0) << "no more than the largest";
}

TEST(SafetyLimits, NoSequenceOfRequestsLoosensAnything) {
  SplitMix random(7);
  for (int round = 0; round < 200; ++round) {
    SafetyLimits limits(all_limits());
    for (int n = 0; n < 50; ++n) {
      const DeviceLimits before = limits.current();
      DeviceLimits wanted;
      for (const auto field : kFields) {
        const double nasty[] = {kNan, kInf, -kInf, 0.0, -1.0, 1e300};
        wanted.*field = random.once_in(3) ? nasty[random.below(6)] : all_limits().*field * random.uniform(0.0, 3.0);
      }
      wanted.peak_s = random.uniform(-1.0, 1e6);
      wanted.workspace_min_m = random.vector(0.2);
      wanted.workspace_max_m = random.vector(0.2);
      if (random.once_in(5)) wanted.workspace_max_m.x() = kNan;
      limits.tighten(wanted);
      expect_no_looser(limits.current(), before);
    }
    EXPECT_EQ(limits.release_n_per_s(), 2000.0);
    EXPECT_EQ(limits.release_nm_per_s(), 100.0);
  }
}

TEST(SafetyLimits, WhatMakesNoSenseGivesNothing) {
  for (const double nonsense : {kNan, kInf, 0.0, -1.0, 1e10, 5e-324}) {
    DeviceLimits device = all_limits();
    device.max_force_n = nonsense;
    EXPECT_EQ(SafetyLimits(device).current().max_force_n, 0.0);
    EXPECT_EQ(SafetyLimits(device).current().max_torque_nm, 0.0);
    device = all_limits();
    device.max_slew_n_per_s = nonsense;
    EXPECT_EQ(SafetyLimits(device).current().max_force_n, 0.0);
    device = all_limits();
    device.max_torque_nm = nonsense;
    EXPECT_EQ(SafetyLimits(device).current().max_torque_nm, 0.0);
    EXPECT_EQ(SafetyLimits(device).current().max_force_n, 8.0);
    device = all_limits();
    device.max_speed_m_per_s = nonsense;
    EXPECT_EQ(SafetyLimits(device).current().max_speed_m_per_s, kFastestHandMPerS);
    device = all_limits();
    device.continuous_force_n = nonsense;
    EXPECT_EQ(SafetyLimits(device).current().continuous_force_n, 8.0);
    device = all_limits();
    device.peak_s = nonsense;
    EXPECT_EQ(SafetyLimits(device).current().peak_s, 0.0);
  }
}

TEST(SafetyLimits, ForbiddenForceAndTorqueStayForbidden) {
  SafetyLimits limits(
      DeviceLimits{.max_force_n = 8.0, .max_slew_n_per_s = 2000.0, .max_torque_nm = 0.5, .max_torque_slew_nm_per_s = 100.0});
  limits.forbid_force();
  limits.tighten({.max_force_n = 3.0, .max_torque_nm = 0.1, .continuous_force_n = 1.0});
  EXPECT_EQ(limits.current().max_force_n, 0.0);
  EXPECT_EQ(limits.current().continuous_force_n, 0.0);
  EXPECT_EQ(limits.current().max_torque_nm, 0.0);
  EXPECT_EQ(limits.device().max_force_n, 8.0) << "what is still written is released as fast as before";
}

TEST(SafetyLimits, AForbiddenTorqueLeavesTheForce) {
  SafetyLimits limits(
      DeviceLimits{.max_force_n = 8.0, .max_slew_n_per_s = 2000.0, .max_torque_nm = 0.5, .max_torque_slew_nm_per_s = 100.0});
  limits.forbid_torque();
  limits.tighten({.max_torque_nm = 0.1});
  EXPECT_EQ(limits.current().max_torque_nm, 0.0);
  EXPECT_EQ(limits.current().max_force_n, 8.0);
  EXPECT_EQ(limits.device().max_torque_nm, 0.5) << "what is still written is released as fast as before";
}

TEST(SafetyLimits, ADeviceTooSlowToReleaseGetsTheSlewThatReleases) {
  DeviceLimits device = all_limits();
  device.max_slew_n_per_s = 1.0;
  device.max_torque_slew_nm_per_s = 0.0;
  EXPECT_EQ(SafetyLimits(device).current().max_slew_n_per_s, 800.0) << "the largest force in 10 ms";
  EXPECT_EQ(SafetyLimits(device).current().max_torque_slew_nm_per_s, 50.0) << "the largest torque in 10 ms";
}

TEST(SafetyLimits, AnAxisWithoutEndsHasNone) {
  DeviceLimits device = all_limits();
  device.workspace_max_m = Vec3(-0.1, kNan, 0.1);
  const SafetyLimits limits(device);
  EXPECT_EQ(limits.current().workspace_max_m.x(), kInf);
  EXPECT_EQ(limits.current().workspace_min_m.y(), -kInf);
  EXPECT_EQ(limits.current().workspace_max_m.z(), 0.1);
}

}  // namespace
}  // namespace hapton
