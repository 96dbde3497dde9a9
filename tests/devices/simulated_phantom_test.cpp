#include "devices/simulated_phantom.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <set>
#include <vector>

#include "core/math/rotation_vector.h"
#include "devices/model_a.h"
#include "tests/support/time_units.h"
#include "watchdog/heartbeat_page.h"

namespace hapton {
namespace {

// A wall of 1 kN/m at z = 0 that fills the half space below, computed as a haptics node would: from the sample, one step later.
Vec3 wall_force(const Vec3& p_WD) { return {0.0, 0.0, std::max(0.0, -1000.0 * p_WD.z())}; }

Vec3 limited(const Vec3& force) { return force.norm() > model_a::kMaxForceN ? Vec3(force.normalized() * model_a::kMaxForceN) : force; }

TEST(SimulatedPhantom, HasTheMemosData) {
  SimulatedPhantom device({});
  EXPECT_NEAR(device.limits().max_force_n, 8.4516, 1e-4);
  EXPECT_TRUE((device.limits().workspace_max_m - device.limits().workspace_min_m).isApprox(Vec3(0.2667, 0.1905, 0.381), 1e-12));
}

TEST(SimulatedPhantom, ReportsPositionsOnThe800DpiGridAndAnglesOn512Counts) {
  SimulatedPhantom device({});
  std::set<long> pitch_counts;
  for (std::int64_t now = 5; now < 3000 * kMs; now += kMs) {
    const DeviceSample sample = device.read(now);
    ASSERT_EQ(sample.time_ns, now);
    for (int axis = 0; axis < 3; ++axis) {
      const double counts = sample.p_WD[axis] * 800.0 / 0.0254;
      ASSERT_NEAR(counts, std::round(counts), 1e-7);
    }
    ASSERT_LE((sample.p_WD - device.exact_position_m()).cwiseAbs().maxCoeff(), 0.5 * 0.0254 / 800.0 + 1e-12);
    // q = Ry(yaw) Rx(pitch) Rz(roll): the angles read back are whole counts.
    const Mat3 r = sample.q_WT.toRotationMatrix();
    const double step = 2.0 * std::numbers::pi / 512.0;
    for (const double angle : {std::asin(-r(1, 2)), std::atan2(r(0, 2), r(2, 2)), std::atan2(r(1, 0), r(1, 1))}) {
      ASSERT_NEAR(angle / step, std::round(angle / step), 1e-6);
    }
    pitch_counts.insert(std::lround(std::asin(-r(1, 2)) / step));
  }
  EXPECT_GT(pitch_counts.size(), 10U);
}

TEST(SimulatedPhantom, TrajectoryDoesNotDependOnTheServoRate) {
  const auto run = [](std::int64_t dt) {
    SimulatedPhantom device({.seed = 5, .stylus = {}});
    for (std::int64_t now = 0; now <= 4000 * kMs; now += dt) {
      device.read(1000 + now);
      // The same forces at the same times, whatever the rate.
      if (now % (4 * kMs) == 0)
        device.write({.force_n = limited(Vec3(0.3, -0.2, 20.0 * std::sin(1e-9 * static_cast<double>(now))))}, 1000 + now);
    }
    return device.exact_position_m();
  };
  const Vec3 slow = run(4 * kMs);
  for (const std::int64_t dt : {100'000L, 250'000L, 1'000'000L, 2'000'000L}) {
    EXPECT_LT((run(dt) - slow).norm(), 1e-8) << dt;
  }
}

TEST(SimulatedPhantom, SameSeedSameMotionOtherSeedOtherMotion) {
  const auto run = [](std::uint64_t seed) {
    SimulatedPhantom device({.seed = seed, .stylus = {}});
    for (std::int64_t now = 0; now < 2000 * kMs; now += kMs) device.write({.force_n = wall_force(device.read(now).p_WD)}, now + 100'000);
    return device.exact_position_m();
  };
  EXPECT_EQ(run(3), run(3));
  EXPECT_GT((run(3) - run(4)).norm(), 1e-3);
}

TEST(SimulatedPhantom, ForcePushesTheHandBackByItsStiffness) {
  StylusModel frictionless;
  frictionless.friction_n = 0.0;
  SimulatedPhantom device({.seed = 1, .stylus = frictionless});
  const Vec3 place(0.01, 0.02, 0.05);
  device.set_hand_target(place);
  for (std::int64_t now = 0; now < 3000 * kMs; now += kMs) device.read(now);
  EXPECT_LT((device.exact_position_m() - place).norm(), 1e-6);
  device.write({.force_n = Vec3(0.0, 0.0, 4.0)}, 3000 * kMs);
  for (std::int64_t now = 3000 * kMs; now < 6000 * kMs; now += kMs) device.read(now);
  const StylusModel model;
  const double expected_shift_m = 4.0 * (1.0 / model.hand_stiffness_n_per_m + 1.0 / model.structure_stiffness_n_per_m());
  EXPECT_NEAR(device.exact_position_m().z() - place.z(), expected_shift_m, 1e-6);
}

// hapton_watchdog cuts the motors in this way from its own process; the device side does so with cut().
TEST(SimulatedPhantom, ItsMotorsAreReportedAndCutThroughTheHeartbeatPage) {
  StylusModel frictionless;
  frictionless.friction_n = 0.0;
  SimulatedPhantom device({.seed = 1, .stylus = frictionless});
  const auto page = std::make_unique<HeartbeatPage>();
  device.use_heartbeat_page(*page);
  EXPECT_EQ(page->means.load(), CutMeans::simulated);
  const Vec3 place(0.01, 0.02, 0.05);
  device.set_hand_target(place);
  std::int64_t now = 0;
  const auto pushed_by_mm = [&] {
    for (const std::int64_t end = now + 3000 * kMs; now < end; now += kMs) {
      device.read(now);
      device.write({.force_n = Vec3(1.0, 2.0, 4.0)}, now);
    }
    return 1e3 * (device.exact_position_m().z() - place.z());
  };
  EXPECT_GT(pushed_by_mm(), 5.0);
  EXPECT_EQ(page->motors_n[0].load(), 1.0);
  EXPECT_EQ(page->motors_n[1].load(), 2.0);
  EXPECT_EQ(page->motors_n[2].load(), 4.0);
  page->is_cut = 1;
  EXPECT_NEAR(pushed_by_mm(), 0.0, 1e-3);
  page->is_cut = 0;
  EXPECT_GT(pushed_by_mm(), 5.0);
  EXPECT_EQ(page->is_cut_within.load(), 0U);
  EXPECT_TRUE(device.cut());
  EXPECT_EQ(page->is_cut_within.load(), 1U);
  EXPECT_NEAR(pushed_by_mm(), 0.0, 1e-3);
  device.restore();
  EXPECT_EQ(page->is_cut_within.load(), 0U);
  EXPECT_GT(pushed_by_mm(), 5.0);
}

TEST(SimulatedPhantom, ButtonsOfItsPathAndOfItsLeadAreDownTogether) {
  const Vec3 place(0.0, 0.0, 0.1);
  const std::vector<TrajectoryRow> path = {{.t_s = 0.0, .p_WD = place, .buttons = 1}, {.t_s = 1.0, .p_WD = place, .buttons = 1}};
  SimulatedPhantom device({.stylus = {}, .path = path});
  const auto buttons_at = [&](std::int64_t ms) { return device.read(ms * kMs).buttons; };
  for (std::int64_t ms = 0; ms < 3000; ms += 50) buttons_at(ms);
  EXPECT_EQ(buttons_at(3000), 1U);
  EXPECT_TRUE(device.press_hand_buttons(2));
  EXPECT_EQ(buttons_at(3001), 3U);
  device.press_hand_buttons(0);
  EXPECT_EQ(buttons_at(3002), 1U);
}

TEST(SimulatedPhantom, StaysInTheWorkspaceUnderAnyForce) {
  SimulatedPhantom device({});
  device.set_hand_target(Vec3(10.0, -10.0, 10.0));
  for (std::int64_t now = 0; now < 2000 * kMs; now += kMs) {
    device.write({.force_n = Vec3(8.0, -8.0, 8.0)}, now);
    const Vec3 p = device.read(now).p_WD;
    ASSERT_TRUE((p.array() <= device.limits().workspace_max_m.array() + 1e-12).all());
    ASSERT_TRUE((p.array() >= device.limits().workspace_min_m.array() - 1e-12).all());
  }
  EXPECT_TRUE(device.read(2000 * kMs).p_WD.isApprox(Vec3(0.13335, -0.09525, 0.1905), 1e-9));
}

struct Exploration {
  int contact_steps = 0;
  int contacts = 0;
  double deepest_m = 0.0;
  double greatest_n = 0.0;
  std::set<HandScript::Phase> phases;
  double path_in_contact_m = 0.0;
};

Exploration explore(std::uint64_t seed, std::int64_t dt, std::int64_t delay, double wall_z) {
  SimulatedPhantom device({.seed = seed, .stylus = {}});
  Exploration result;
  bool was_touching = false;
  Vec3 last = Vec3::Zero();
  for (std::int64_t now = 0; now < 20'000 * kMs; now += dt) {
    const Vec3 p = device.read(now).p_WD;
    const Vec3 force = limited(wall_force(p - Vec3(0.0, 0.0, wall_z)));
    device.write({.force_n = force}, now + delay);
    const bool is_touching = force.norm() > 0.0;
    result.contact_steps += is_touching;
    result.contacts += is_touching && !was_touching;
    if (is_touching && was_touching) result.path_in_contact_m += (p - last).head<2>().norm();
    was_touching = is_touching;
    last = p;
    result.deepest_m = std::max(result.deepest_m, wall_z - p.z());
    result.greatest_n = std::max(result.greatest_n, force.norm());
    result.phases.insert(device.phase());
  }
  return result;
}

TEST(SimulatedPhantom, ScriptFindsAWallItDoesNotKnowAndGoesThroughAllItsPhases) {
  for (const double wall_z : {-0.15, 0.0, 0.1}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const Exploration result = explore(seed, kMs, kMs / 10, wall_z);
      EXPECT_GT(result.contact_steps, 4000) << "seed " << seed << " wall " << wall_z;
      EXPECT_GT(result.contacts, 4) << "seed " << seed;
      EXPECT_LT(result.deepest_m, 0.008) << "seed " << seed;
      EXPECT_GT(result.greatest_n, 1.0) << "seed " << seed;
      EXPECT_GT(result.path_in_contact_m, 0.05) << "seed " << seed;
      EXPECT_EQ(result.phases.size(), 7U) << "seed " << seed;
    }
  }
}

TEST(SimulatedPhantom, AWallStaysStableAtEveryRate) {
  for (const std::int64_t dt : {100'000L, 250'000L, 1'000'000L, 4'000'000L}) {
    const Exploration result = explore(2, dt, 100'000L, 0.0);
    EXPECT_GT(result.contacts, 2) << dt;
    EXPECT_LT(result.contacts, 200) << dt;
    EXPECT_LT(result.deepest_m, 0.009) << dt;
  }
}

// The stylus also turns by whole turns, never faster than an arm, and back.
TEST(SimulatedPhantom, TheLedHandTurnsTheStylus) {
  for (const bool has_torque : {false, true}) {
    SimulatedPhantom device({.stylus = {}, .has_torque = has_torque});
    std::int64_t now = 0;
    const auto turn_during = [&](double seconds) {
      double largest_step_rad = 0.0;
      double sum = 0.0;
      Quat last = device.read(now).q_WT;
      for (const std::int64_t end = now + static_cast<std::int64_t>(1e9 * seconds); now < end;) {
        const Quat next = device.read(now += 1'000'000).q_WT;
        const double turn = turn_between(last, next).y();
        largest_step_rad = std::max(largest_step_rad, turn_between(last, next).norm());
        sum += turn;
        last = next;
      }
      EXPECT_LT(largest_step_rad, has_torque ? 0.01 : 0.02) << "in one sample; gimbals have steps of 0.012 rad";
      return sum;
    };
    ASSERT_TRUE(device.set_hand_target(device.read(now).p_WD));
    turn_during(0.5);
    ASSERT_TRUE(device.turn_hand({4.0 * std::numbers::pi, 0.0, 0.0}));
    EXPECT_NEAR(turn_during(1.0), 2.0, 0.3);
    EXPECT_NEAR(turn_during(7.0), 4.0 * std::numbers::pi - 2.0, 0.3);
    device.turn_hand({0.5, 0.0, 0.0});
    EXPECT_NEAR(turn_during(1.0), -2.0, 0.3) << "a target other than zero also undoes whole turns";
    device.turn_hand({4.0 * std::numbers::pi, 0.0, 0.0});
    EXPECT_NEAR(turn_during(2.0), 2.0, 0.3);
    device.turn_hand(Vec3::Zero());
    EXPECT_NEAR(turn_during(2.0), 0.0, 0.3) << "a target of zero leaves whole turns";
    device.turn_hand({1.0, 0.0, 0.0});
    turn_during(2.0);
    device.turn_hand(Vec3::Zero());
    EXPECT_NEAR(turn_during(2.0), -1.0, 0.3);
    device.turn_hand(Vec3::Constant(std::numeric_limits<double>::quiet_NaN()));
    EXPECT_NEAR(turn_during(0.5), 0.0, 0.1);
  }
}

TEST(SimulatedPhantom, ALongPauseIsShortened) {
  SimulatedPhantom paused({}), at_limit({});
  paused.read(0);
  at_limit.read(0);
  const Vec3 after_pause = paused.read(60'000 * kMs).p_WD;
  const Vec3 after_limit = at_limit.read(SimulatedPhantom::kLongestPauseNs).p_WD;
  EXPECT_EQ(after_pause, after_limit);
}

}  // namespace
}  // namespace hapton
