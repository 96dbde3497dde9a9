// The small stages of the governor, each at the edges of what it allows.
#include <gtest/gtest.h>

#include <limits>
#include <set>

#include "safety/command_filter.h"
#include "safety/dead_mans_switch.h"
#include "safety/fault_debouncer.h"
#include "safety/ramp_up.h"
#include "safety/safety_fault.h"
#include "safety/vector_limit.h"
#include "safety/workspace_stop.h"

namespace hapton {
namespace {

constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
using Verdict = CommandFilter::Verdict;

WrenchCommand command(double force_n, std::int64_t sample_ns) { return {{.force_n = {force_n, 0, 0}}, sample_ns}; }

TEST(CommandFilter, TakesWhatIsNewerThanTheLastAndNeitherOldNorOfTheFuture) {
  constexpr std::int64_t kNow = 100'000'000;
  struct Row {
    std::int64_t sample_ns;
    Verdict verdict;
  };
  const Row rows[] = {{kNow + 1, Verdict::future},
                      {kNow - kCommandTimeoutNs, Verdict::old},
                      {kNow - kCommandTimeoutNs + 1, Verdict::accepted},
                      {kNow - kCommandTimeoutNs + 1, Verdict::old},
                      {kNow - 5, Verdict::accepted},
                      {kNow - 6, Verdict::old},
                      {kNow, Verdict::accepted}};
  CommandFilter filter;
  double force_n = 0.0;
  double accepted_n = 0.0;
  for (const Row& row : rows) {
    const Verdict verdict = filter.take(command(++force_n, row.sample_ns), kNow);
    EXPECT_EQ(verdict, row.verdict) << force_n;
    if (verdict == Verdict::accepted) accepted_n = force_n;
    EXPECT_EQ(filter.is_live(), accepted_n > 0.0);
    if (accepted_n > 0.0) {
      EXPECT_EQ(filter.wrench().force_n.x(), accepted_n);
    }
  }
}

TEST(CommandFilter, TheFirstMayReplyToASampleAtTimeZero) {
  CommandFilter filter;
  EXPECT_EQ(filter.take(command(1.0, 0), 0), Verdict::accepted);
  EXPECT_EQ(filter.take(command(1.0, 0), 0), Verdict::old);
}

TEST(CommandFilter, ACommandThatIsNotFiniteEndsTheOneBefore) {
  CommandFilter filter;
  ASSERT_EQ(filter.take(command(1.0, 10), 10), Verdict::accepted);
  EXPECT_EQ(filter.take(command(kNotANumber, 11), 11), Verdict::force_not_finite);
  EXPECT_FALSE(filter.is_live());
  ASSERT_EQ(filter.take(command(1.0, 12), 12), Verdict::accepted);
  EXPECT_EQ(filter.take({{.torque_nm = {0, kNotANumber, 0}}, 13}, 13), Verdict::torque_not_finite);
  EXPECT_FALSE(filter.is_live());
  EXPECT_EQ(filter.take({{.force_n = {kNotANumber, 0, 0}, .torque_nm = {0, kNotANumber, 0}}, 13}, 13), Verdict::force_not_finite);
  EXPECT_EQ(filter.take(command(1.0, 12), 14), Verdict::old) << "sample 12 is still old";
}

TEST(CommandFilter, TimesOutOnceAfterEachCommand) {
  CommandFilter filter;
  EXPECT_FALSE(filter.times_out(kCommandTimeoutNs)) << "there was no command";
  ASSERT_EQ(filter.take(command(1.0, 100), 105), Verdict::accepted);
  EXPECT_DOUBLE_EQ(filter.left_s(100), 0.02);
  EXPECT_NEAR(filter.left_s(100 + kCommandTimeoutNs / 4), 0.015, 1e-12);
  EXPECT_FALSE(filter.times_out(100 + kCommandTimeoutNs - 1));
  EXPECT_TRUE(filter.is_live());
  EXPECT_TRUE(filter.times_out(100 + kCommandTimeoutNs)) << "counted from its sample";
  EXPECT_FALSE(filter.is_live());
  EXPECT_FALSE(filter.times_out(100 + kCommandTimeoutNs + 1));
  ASSERT_EQ(filter.take(command(1.0, 101 + kCommandTimeoutNs), 101 + kCommandTimeoutNs), Verdict::accepted);
  filter.release();
  EXPECT_FALSE(filter.times_out(200 + 2 * kCommandTimeoutNs)) << "its force was released";
}

TEST(DeadMansSwitch, WhatIsRequiredStaysRequired) {
  DeadMansSwitch dead_mans_switch;
  EXPECT_TRUE(dead_mans_switch.is_held({.buttons = 0, .is_held = true}));
  EXPECT_FALSE(dead_mans_switch.is_held({.buttons = ~0U, .is_held = false}));
  for (const int none : {-1, 0, 33}) dead_mans_switch.require_button(none);
  EXPECT_EQ(dead_mans_switch.required_buttons(), 0U);
  dead_mans_switch.require_button(1);
  dead_mans_switch.require_button(32);
  dead_mans_switch.require_button(1);
  EXPECT_EQ(dead_mans_switch.required_buttons(), 0x80000001U);
  EXPECT_FALSE(dead_mans_switch.is_held({.buttons = 1U, .is_held = true}));
  EXPECT_FALSE(dead_mans_switch.is_held({.buttons = 0x80000000U, .is_held = true}));
  EXPECT_TRUE(dead_mans_switch.is_held({.buttons = 0x80000101U, .is_held = true}));
}

TEST(FaultDebouncer, TripsAtTheFifthAndForgetsOneInTenthsOfASecond) {
  constexpr std::int64_t kForgetNs = FaultDebouncer::kForgetNs;
  FaultDebouncer faults;
  for (int n = 1; n <= 4; ++n) EXPECT_FALSE(faults.note(5));
  EXPECT_TRUE(faults.note(5));
  EXPECT_TRUE(faults.note(6));
  faults.clear();
  for (int n = 1; n <= 4; ++n) EXPECT_FALSE(faults.note(7));
  EXPECT_TRUE(faults.note(7 + kForgetNs - 1)) << "none is forgotten";
  faults.clear();
  for (int n = 1; n <= 4; ++n) EXPECT_FALSE(faults.note(kForgetNs));
  EXPECT_FALSE(faults.note(2 * kForgetNs)) << "one is forgotten";
  EXPECT_TRUE(faults.note(3 * kForgetNs - 1)) << "its tenth counts from where the one before ended";
  faults.clear();
  for (int n = 1; n <= 4; ++n) EXPECT_FALSE(faults.note(4 * kForgetNs));
  EXPECT_FALSE(faults.note(8 * kForgetNs)) << "all four are forgotten, and this is the first";
  for (int n = 2; n <= 4; ++n) EXPECT_FALSE(faults.note(8 * kForgetNs + 50));
  EXPECT_TRUE(faults.note(9 * kForgetNs - 1));
}

TEST(RampUp, RisesEvenlyToTheWholeForce) {
  RampUp ramp;
  ramp.begin(1000);
  EXPECT_EQ(ramp.share(1000), 0.0);
  EXPECT_NEAR(ramp.share(1000 + kRampNs / 4), 0.25, 1e-9);
  EXPECT_NEAR(ramp.share(1000 + kRampNs / 4 * 3), 0.75, 1e-9);
  EXPECT_EQ(ramp.share(1000 + kRampNs), 1.0);
  EXPECT_EQ(ramp.share(1000 + 5 * kRampNs), 1.0);
}

TEST(VectorLimit, ShortensOnlyWhatIsTooLong) {
  const Vec3 v(3.0, -4.0, 12.0);  // its length is 13
  EXPECT_EQ(shortened(v, 13.0), v);
  EXPECT_EQ(shortened(v, 14.0), v);
  const Vec3 half = shortened(v, 6.5);
  EXPECT_LE(half.norm(), 6.5);
  EXPECT_NEAR((half - 0.5 * v).norm(), 0.0, 1e-10);
  EXPECT_EQ(shortened(v, 0.0), Vec3(Vec3::Zero()));
  EXPECT_EQ(shortened(Vec3::Zero(), 0.0), Vec3(Vec3::Zero()));
  const Vec3 huge = shortened(Vec3(3e250, -4e250, 0.0), 5.0);
  EXPECT_NEAR((huge - Vec3(3.0, -4.0, 0.0)).norm(), 0.0, 1e-9);
  EXPECT_LE(huge.norm(), 5.0);
}

TEST(WorkspaceStop, OutwardForceFadesOverTheMarginOfEachAxis) {
  DeviceLimits limits;
  limits.workspace_min_m = Vec3(-0.1, -0.2, -0.02);
  limits.workspace_max_m = Vec3(0.1, 0.3, 0.02);  // z is short: its margin is a tenth of 40 mm
  struct Row {
    int axis;
    double outward, at_m, share;
  };
  const Row rows[] = {{0, 1, 0.0, 1.0},    {0, 1, 0.09, 1.0},      {0, 1, 0.095, 0.5}, {0, 1, 0.1, 0.0},   {0, 1, 0.15, 0.0},
                      {0, -1, 0.095, 1.0}, {0, -1, -0.0925, 0.75}, {0, -1, -0.1, 0.0}, {0, -1, -0.2, 0.0}, {0, -1, 0.2, 1.0},
                      {1, 1, 0.295, 0.5},  {1, -1, -0.1975, 0.25}, {2, 1, 0.016, 1.0}, {2, 1, 0.018, 0.5}, {2, -1, -0.019, 0.25}};
  for (const Row& row : rows) {
    SCOPED_TRACE(testing::Message() << "axis " << row.axis << " at " << row.at_m << " towards " << row.outward);
    Vec3 p = Vec3::Zero();
    p[row.axis] = row.at_m;
    EXPECT_NEAR(WorkspaceStop::share(limits, row.axis, row.outward, p), row.share, 1e-9);
    Vec3 force(1.0, 1.0, 1.0);
    force[row.axis] = 2.0 * row.outward;
    Vec3 expected = force;
    expected[row.axis] *= row.share;
    EXPECT_NEAR((WorkspaceStop::shape(limits, force, p) - expected).norm(), 0.0, 1e-8) << "the other axes stay";
  }
}

// A tenth of such an axis may be less than the smallest number: the force would be 0 / 0.
TEST(WorkspaceStop, AnAxisOfTheSmallestNumbersEndsTheForceAndIsFinite) {
  constexpr double kSmallest = std::numeric_limits<double>::denorm_min();
  for (const double length_m : {kSmallest, 20.0 * kSmallest, std::numeric_limits<double>::min()}) {
    DeviceLimits limits;
    limits.workspace_min_m = Vec3(0.0, -1.0, -1.0);
    limits.workspace_max_m = Vec3(length_m, 1.0, 1.0);
    EXPECT_EQ(WorkspaceStop::share(limits, 0, -1.0, Vec3::Zero()), 0.0) << length_m;
    EXPECT_EQ(WorkspaceStop::share(limits, 0, 1.0, Vec3(length_m, 0.0, 0.0)), 0.0) << length_m;
    EXPECT_EQ(WorkspaceStop::share(limits, 0, 1.0, Vec3::Zero()), 1.0) << length_m;
    EXPECT_EQ(WorkspaceStop::shape(limits, Vec3(-3.0, 2.0, 0.0), Vec3::Zero()), Vec3(0.0, 2.0, 0.0)) << length_m;
  }
}

TEST(SafetyFault, EachHasANameAndAReasonOfItsOwn) {
  std::set<std::string_view> names;
  std::set<std::string_view> reasons;
  for (int n = 0; n < kSafetyFaults; ++n) {
    names.insert(to_string(static_cast<SafetyFault>(n)));
    reasons.insert(describe(static_cast<SafetyFault>(n)));
  }
  EXPECT_EQ(names.size(), static_cast<std::size_t>(kSafetyFaults));
  EXPECT_EQ(reasons.size(), static_cast<std::size_t>(kSafetyFaults));
  EXPECT_FALSE(names.contains("unknown"));
  EXPECT_EQ(to_string(SafetyFault::device), "device");
  EXPECT_EQ(to_string(static_cast<SafetyFault>(200)), "unknown");
  EXPECT_EQ(describe(static_cast<SafetyFault>(200)), "unknown");
  EXPECT_EQ(to_string(static_cast<GovernorState>(200)), "unknown");
  EXPECT_EQ(to_string(GovernorState::switch_released), "switch released");
}

}  // namespace
}  // namespace hapton
