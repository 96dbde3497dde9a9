#include "devices/hand_script.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <utility>

namespace hapton {
namespace {

HandScript::Options box_options(std::uint64_t seed) { return {seed, Vec3(-0.1, -0.1, -0.2), Vec3(0.1, 0.1, 0.2), Vec3(0.0, 0.0, 0.18)}; }

TEST(HandScript, MovesSmoothlyAndStaysInTheWorkspaceWhereThereIsNothingToTouch) {
  HandScript script(box_options(9));
  Vec3 last = box_options(9).start_m;
  for (int step = 0; step < 60'000; ++step) {
    const Vec3 next = script.step(last, Vec3::Zero()).p_WH;
    ASSERT_LE((next - last).norm(), 0.0007) << step;
    ASSERT_GE((next - box_options(9).workspace_min_m).minCoeff(), 0.0) << step;
    ASSERT_GE((box_options(9).workspace_max_m - next).minCoeff(), 0.0) << step;
    last = next;
  }
}

TEST(HandScript, SurvivesAForceThatMakesNoSense) {
  HandScript script(box_options(2));
  const Vec3 forces[] = {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 0, -8), Vec3(0, 8, 0), Vec3::Zero()};
  Vec3 last = box_options(2).start_m;
  for (int step = 0; step < 60'000; ++step) {
    last = script.step(last, forces[(step / 37) % 5]).p_WH;
    ASSERT_TRUE(last.allFinite());
  }
}

// A device that does not move and whose force never ends: the hand neither pulls farther and farther, nor leaves its workspace, nor waits
// for the force to end.
TEST(HandScript, AForceThatNeverEndsHoldsUpNothing) {
  constexpr double kMaxPullM = 0.015;
  for (const double height : {0.0, -0.2}) {  // in the middle, and at the lower end of the workspace
    SCOPED_TRACE(height);
    HandScript script(box_options(5));
    const Vec3 device(0.0, 0.0, height);
    script.lead(device);
    for (int step = 0; step < 1000; ++step) (void)script.step(device, Vec3::Zero());
    script.lead(std::nullopt);
    std::set<HandScript::Phase> phases;
    double largest_pull_m = 0.0;
    const auto is_rubbing = [&] { return script.phase() == HandScript::Phase::press || script.phase() == HandScript::Phase::slide; };
    for (int step = 0; step < 20'000; ++step) {
      const bool was_rubbing = is_rubbing();
      const Vec3 hand = script.step(device, Vec3(0.0, 0.0, 0.5)).p_WH;
      ASSERT_GE(hand.z(), -0.2) << step;
      phases.insert(script.phase());
      if (was_rubbing && is_rubbing()) largest_pull_m = std::max(largest_pull_m, (hand - device).norm());
    }
    EXPECT_TRUE(phases.contains(HandScript::Phase::circle)) << "it waits for the end of the force before it taps";
    EXPECT_LE(largest_pull_m, kMaxPullM + 1e-12);
    EXPECT_GT(largest_pull_m, height == 0.0 ? 0.9 * kMaxPullM : 0.0) << "it presses less than it wants to";
  }
}

// The hand feels the same force all the time, and holds the stylus where it wants it.
TEST(HandScript, CirclesOnceOrTwiceWithARadiusOfMillimetres) {
  double least_turn = 10.0, most_turn = 0.0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    HandScript script({seed, Vec3::Constant(-2.0), Vec3::Constant(2.0), Vec3::Zero()});
    Vec3 last = Vec3::Zero();
    const auto step = [&] { return script.step(last, Vec3(0.0, 0.0, 1.0)).p_WH; };
    for (int n = 0; n < 20'000 && script.phase() != HandScript::Phase::circle; ++n) last = step();
    ASSERT_EQ(script.phase(), HandScript::Phase::circle);
    Vec3 motion_before = Vec3::Zero();
    double turned_rad = 0.0, way_m = 0.0;
    while (script.phase() == HandScript::Phase::circle && turned_rad < 100.0) {
      const Vec3 next = step();
      const Vec3 motion = (next - last).cwiseProduct(Vec3(1.0, 1.0, 0.0));
      last = next;
      if (script.phase() != HandScript::Phase::circle) break;
      if (motion_before != Vec3::Zero()) turned_rad += std::acos(std::min(1.0, motion.normalized().dot(motion_before.normalized())));
      way_m += motion.norm();
      motion_before = motion;
    }
    const double turns = turned_rad / (2.0 * std::numbers::pi);
    least_turn = std::min(least_turn, turns);
    most_turn = std::max(most_turn, turns);
    EXPECT_GT(way_m / turned_rad, 0.004 - 1e-4);
    EXPECT_LT(way_m / turned_rad, 0.012 + 1e-4);
  }
  EXPECT_GT(least_turn, 0.98);
  EXPECT_LT(least_turn, 1.3);
  EXPECT_GT(most_turn, 1.7);
  EXPECT_LT(most_turn, 2.02);
}

TEST(HandScript, FollowsALeadAndReturnsToItsScript) {
  HandScript script(box_options(1));
  Vec3 last = box_options(1).start_m;
  script.lead(Vec3(0.05, -0.05, 0.0));
  for (int step = 0; step < 1000; ++step) last = script.step(last, Vec3::Zero()).p_WH;
  EXPECT_EQ(script.phase(), HandScript::Phase::led);
  EXPECT_LT((last - Vec3(0.05, -0.05, 0.0)).norm(), 1e-12);
  script.lead(Vec3::Constant(std::numeric_limits<double>::quiet_NaN()));
  last = script.step(last, Vec3::Zero()).p_WH;
  EXPECT_TRUE(last.allFinite());
  script.lead(std::nullopt);
  for (int step = 0; step < 2000; ++step) last = script.step(last, Vec3::Zero()).p_WH;
  EXPECT_NE(script.phase(), HandScript::Phase::led);
  EXPECT_GT((last - Vec3(0.05, -0.05, 0.0)).norm(), 1e-3);
}

HandScript::Options path_options(bool repeats) {
  HandScript::Options options = box_options(3);
  options.path = {{10.0, Vec3(0.05, 0, 0), Quat::Identity()},
                  {11.0, Vec3(0.05, 0.02, 0), Quat::Identity()},
                  {12.0, Vec3(-0.03, 0.02, 0), Quat::Identity()}};
  options.repeat_path = repeats;
  return options;
}

// The position of the hand, this many steps after it has reached the path's first row.
Vec3 hand_on_path(HandScript& script, int steps) {
  Vec3 hand = box_options(3).start_m;
  for (int step = 0; step < 5000 && (hand - Vec3(0.05, 0, 0)).norm() > 1e-12; ++step) hand = script.step(hand, Vec3::Zero()).p_WH;
  EXPECT_LT((hand - Vec3(0.05, 0, 0)).norm(), 1e-12) << "goes to the first row first";
  for (int step = 0; step < steps; ++step) hand = script.step(hand, Vec3::Zero()).p_WH;
  return hand;
}

TEST(HandScript, HoldsTheButtonsOfAPathFromRowToRow) {
  HandScript::Options options = path_options(true);
  options.path[1].buttons = 3;
  HandScript script(options);
  const auto buttons_after = [&](int steps) {
    std::uint32_t buttons = 0;
    for (int step = 0; step < steps; ++step) buttons = script.step(Vec3::Zero(), Vec3::Zero()).buttons;
    return buttons;
  };
  (void)hand_on_path(script, 500);
  EXPECT_EQ(buttons_after(1), 0U);
  EXPECT_EQ(buttons_after(600), 3U);
  EXPECT_EQ(buttons_after(900), 0U) << "from its beginning again";
  EXPECT_EQ(buttons_after(1000), 3U);
  script.lead(Vec3(0.01, 0.0, 0.0));
  EXPECT_EQ(buttons_after(2), 0U) << "whoever leads the hand presses the buttons";
}

TEST(HandScript, FollowsAPathRowByRowAndStaysAtItsEnd) {
  for (const auto& [steps, there] : {std::pair(500, Vec3(0.05, 0.01, 0)), {1500, Vec3(0.01, 0.02, 0)}, {9000, Vec3(-0.03, 0.02, 0)}}) {
    HandScript script(path_options(false));
    EXPECT_LT((hand_on_path(script, steps) - there).norm(), 1e-9) << steps;
    EXPECT_EQ(script.phase(), HandScript::Phase::path);
  }
}

TEST(HandScript, BeginsAPathAgainAtTheSpeedOfAnArm) {
  HandScript script(path_options(true));
  Vec3 last = hand_on_path(script, 1999);
  for (int step = 0; step < 1000; ++step) {
    const Vec3 next = script.step(last, Vec3::Zero()).p_WH;
    ASSERT_LE((next - last).norm(), 1e-3 * HandScript::kMaxPathSpeed + 1e-12) << "the way back is a jump";
    last = next;
  }
  EXPECT_LT((last - Vec3(0.05, 0.02, 0)).norm(), 1e-3);
}

TEST(HandScript, TakesAPathNoFartherThanTheWorkspaceAndYieldsToALead) {
  HandScript::Options options = path_options(false);
  options.path.push_back({13.0, Vec3(0.0, 5.0, -5.0), Quat::Identity()});
  HandScript script(options);
  EXPECT_EQ(hand_on_path(script, 9000), Vec3(0.0, 0.1, -0.2));
  script.lead(Vec3(0.02, 0.03, 0.1));
  Vec3 hand = Vec3::Zero();
  for (int step = 0; step < 2000; ++step) hand = script.step(hand, Vec3::Zero()).p_WH;
  EXPECT_EQ(hand, Vec3(0.02, 0.03, 0.1));
  script.lead(std::nullopt);
  EXPECT_LT((hand_on_path(script, 500) - Vec3(0.05, 0.01, 0)).norm(), 1e-9) << "from its beginning";
}

TEST(HandScript, ALedHandHoldsTheStylusStillAndContinuesFromThere) {
  HandScript script(box_options(1));
  Vec3 last = box_options(1).start_m;
  HandIntention before;
  for (int step = 0; step < 700; ++step) before = script.step(last, Vec3::Zero()), last = before.p_WH;
  ASSERT_GT(before.gimbal_rad.norm(), 0.01);
  script.lead(Vec3(0.05, -0.05, 0.0));
  for (int step = 0; step < 1000; ++step) EXPECT_EQ(script.step(last, Vec3::Zero()).gimbal_rad, before.gimbal_rad);
  script.lead(std::nullopt);
  const HandIntention after = script.step(last, Vec3::Zero());
  EXPECT_NE(after.gimbal_rad, before.gimbal_rad);
  EXPECT_LT((after.gimbal_rad - before.gimbal_rad).norm(), 0.01) << "without a jump";
}

// The hand touches a surface at the limit of the workspace, and the surface's normal leads out of the workspace. The hand retreats only as
// far as that limit, and then goes elsewhere.
TEST(HandScript, LeavesASurfaceAtTheLimitOfItsWorkspace) {
  HandScript script(box_options(4));
  const Vec3 border(0.0, -0.1, 0.0);
  Vec3 last = box_options(4).start_m;
  script.lead(border);
  for (int step = 0; step < 1000; ++step) last = script.step(last, Vec3(0, -1, 0)).p_WH;
  ASSERT_EQ(last, border);
  script.lead(std::nullopt);
  for (int step = 0; step < 20'000; ++step) last = script.step(last, Vec3::Zero()).p_WH;
  EXPECT_GT((last - border).norm(), 0.01);
}

TEST(HandScript, GoesToTheReportedScene) {
  const Vec3 pin(0.07, -0.08, 0.05);  // with a radius of 2 mm, to the side: a blind search does not find it within seconds
  const auto seconds_until_touch = [&](bool is_reported) {
    HandScript script(box_options(3));
    Vec3 last = box_options(3).start_m;
    if (is_reported) script.aim(std::array{pin, Vec3(9, 9, 9), Vec3(pin + Vec3(0, 0.001, 0))});
    for (int step = 0; step < 20'000; ++step) {
      last = script.step(last, Vec3::Zero()).p_WH;
      if ((last - pin).head<2>().norm() < 0.002 && last.z() <= pin.z()) return 1e-3 * step;
    }
    return 1e9;
  };
  EXPECT_LT(seconds_until_touch(true), 4.0);
  EXPECT_GT(seconds_until_touch(false), 10.0);
}

TEST(HandScript, AimsOutOfItsReachLeaveItAsItWas) {
  HandScript script(box_options(1)), other(box_options(1));
  Vec3 a = box_options(1).start_m, b = a;
  for (int step = 0; step < 3000; ++step) {
    script.aim(std::array{Vec3(5, 0, 0), Vec3(Vec3::Constant(std::numeric_limits<double>::quiet_NaN()))});
    a = script.step(a, Vec3::Zero()).p_WH;
    b = other.step(b, Vec3::Zero()).p_WH;
  }
  EXPECT_EQ(a, b);
}

// At the old aim there may be nothing left to touch.
TEST(HandScript, NewAimsReplaceAnApproachButNotAContact) {
  HandScript script(box_options(1));
  Vec3 last = box_options(1).start_m;
  const auto step_until = [&](HandScript::Phase phase) {
    for (int step = 0; step < 20'000 && script.phase() != phase; ++step) last = script.step(last, Vec3::Zero()).p_WH;
    ASSERT_EQ(script.phase(), phase);
  };
  script.aim(std::array{Vec3(0.05, 0.0, 0.0)});
  step_until(HandScript::Phase::approach);
  script.aim(std::array{Vec3(0.05, 0.0, 0.0)});
  EXPECT_EQ(script.phase(), HandScript::Phase::approach) << "the same aims again";
  script.aim(std::array{Vec3(-0.05, 0.0, 0.0)});
  EXPECT_EQ(script.phase(), HandScript::Phase::travel);
  step_until(HandScript::Phase::approach);
  EXPECT_LT((last - Vec3(-0.05, 0.0, 0.18)).norm(), 1e-9);
  for (int step = 0; step < 200; ++step) last = script.step(last, Vec3(0, 0, 1)).p_WH;
  ASSERT_EQ(script.phase(), HandScript::Phase::press);
  script.aim(std::array{Vec3(0.0, 0.05, 0.0)});
  EXPECT_EQ(script.phase(), HandScript::Phase::press);
}

TEST(HandScript, ANewLeadReplacesTheOneBefore) {
  HandScript script(box_options(1));
  Vec3 last = box_options(1).start_m;
  for (const Vec3& lead : {Vec3(0.05, -0.05, 0.0), Vec3(-0.05, 0.05, 0.1)}) {
    script.lead(lead);
    for (int step = 0; step < 1000; ++step) last = script.step(last, Vec3::Zero()).p_WH;
    EXPECT_EQ(last, lead);
    EXPECT_EQ(script.phase(), HandScript::Phase::led);
  }
}

TEST(HandScript, TurnsAsThePathDoesFromItsFirstRowOnAndStaysTurnedAtItsEnd) {
  HandScript::Options options = path_options(false);
  const Quat first(Eigen::AngleAxisd(0.2, Vec3::UnitX())), last(Eigen::AngleAxisd(0.6, Vec3::UnitX()));
  options.path[0].q_WT = first;
  options.path[1].q_WT = last;
  options.path[2].q_WT = last;
  HandScript script(options);
  EXPECT_EQ(script.step(Vec3::Zero(), Vec3::Zero()).q_WT->coeffs(), first.coeffs()) << "on the way to the first row";
  (void)hand_on_path(script, 499);
  const Quat middle(Eigen::AngleAxisd(0.4, Vec3::UnitX()));
  EXPECT_LT(script.step(Vec3::Zero(), Vec3::Zero()).q_WT->angularDistance(middle), 1e-9) << "half way between the first two rows";
  for (int step = 0; step < 5000; ++step) script.step(Vec3::Zero(), Vec3::Zero());
  EXPECT_EQ(script.step(Vec3::Zero(), Vec3::Zero()).q_WT->coeffs(), last.coeffs());
}

TEST(HandScript, EndingALeadThatNeverBeganChangesNothing) {
  HandScript script(box_options(1)), other(box_options(1));
  Vec3 a = box_options(1).start_m, b = a;
  for (int step = 0; step < 3000; ++step) {
    script.lead(std::nullopt);
    a = script.step(a, Vec3::Zero()).p_WH;
    b = other.step(b, Vec3::Zero()).p_WH;
  }
  EXPECT_EQ(a, b);
}

}  // namespace
}  // namespace hapton
