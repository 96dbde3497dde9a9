#include "devices/stylus_turn.h"

#include <gtest/gtest.h>

#include "core/math/rotation_vector.h"
#include "devices/model_a.h"
#include "devices/simulated_phantom.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

TEST(StylusTurn, ComesToRestWhereTheHandAndTheTorqueBalance) {
  StylusTurn turn;
  const Quat q_WH = turn_by({0.3, -0.2, 0.1});
  const Vec3 torque_nm(0.05, 0.0, -0.1);
  turn.advance(0, 2'000 * kMs, q_WH, torque_nm);
  EXPECT_LT((turn_between(q_WH, turn.q_WT()) - torque_nm / StylusTurn::kHandNmPerRad).norm(), 1e-6);
}

TEST(StylusTurn, DoesNotDependOnHowOftenItIsRead) {
  const auto after = [](std::int64_t tick_ns) {
    StylusTurn turn;
    for (std::int64_t now = 0; now < 200 * kMs; now += tick_ns) turn.advance(now, now + tick_ns, turn_by({0.3, 0.0, 0.0}), {0.0, 0.1, 0.0});
    return turn.q_WT();
  };
  EXPECT_EQ(after(kMs).coeffs(), after(kMs / 10).coeffs());
  EXPECT_EQ(after(kMs).coeffs(), after(4 * kMs).coeffs());
  EXPECT_EQ(after(kMs).coeffs(), after(kMs / 40).coeffs()) << "finer than its own step";
}

std::vector<TrajectoryRow> turning_path() {
  const Vec3 p(0.0, 0.0, 0.9 * model_a::limits().workspace_max_m.z());
  return {{0.0, p, Quat::Identity()}, {1.0, p, turn_by({0.0, 0.0, 1.0})}};
}

TEST(StylusTurn, ASimulatedHandFollowsTheOrientationsOfItsPath) {
  for (const bool has_torque : {false, true}) {
    SimulatedPhantom device({.path = turning_path(), .has_torque = has_torque});
    DeviceSample sample;
    for (std::int64_t now = 0; now <= 3000 * kMs; now += kMs) sample = device.read(now);
    EXPECT_LT(turn_between(turn_by({0.0, 0.0, 1.0}), sample.q_WT).norm(), 1e-3) << has_torque;
  }
}

TEST(StylusTurn, APathMayHoldTheStylusUpright) {
  for (const bool has_turn : {false, true}) {
    const Vec3 p(0.0, 0.0, 0.9 * model_a::limits().workspace_max_m.z());
    const TrajectoryRow row{.p_WD = p, .has_turn = has_turn};
    SimulatedPhantom device({.path = {row}, .has_torque = true});
    double largest_turn_rad = 0.0;
    for (std::int64_t now = 0; now <= 3000 * kMs; now += kMs) {
      const double turn_rad = turn_between(Quat::Identity(), device.read(now).q_WT).norm();
      if (now > 1000 * kMs) largest_turn_rad = std::max(largest_turn_rad, turn_rad);
    }
    EXPECT_EQ(largest_turn_rad < 1e-3, has_turn) << largest_turn_rad << ": without orientations the hand sways";
  }
}

TEST(StylusTurn, TheMotorsTurnTheStylusUnlessTheyAreCut) {
  SimulatedPhantom device({.path = turning_path(), .has_torque = true});
  EXPECT_GT(device.limits().max_torque_nm, 0.0);
  EXPECT_EQ(SimulatedPhantom({}).limits().max_torque_nm, 0.0);
  const auto turn_after = [&](std::int64_t from) {
    DeviceSample sample;
    for (std::int64_t now = from; now <= from + 1000 * kMs; now += kMs) {
      device.write({.torque_nm = Vec3(0.1, 0.0, 0.0)}, now);
      sample = device.read(now);
    }
    return turn_between(turn_by({0.0, 0.0, 1.0}), sample.q_WT).norm();
  };
  turn_after(0);
  EXPECT_NEAR(turn_after(2000 * kMs), 0.1 / StylusTurn::kHandNmPerRad, 1e-3);
  ASSERT_TRUE(device.cut());
  EXPECT_LT(turn_after(4000 * kMs), 1e-6);
  device.restore();
  EXPECT_NEAR(turn_after(6000 * kMs), 0.1 / StylusTurn::kHandNmPerRad, 1e-3);
}

}  // namespace
}  // namespace hapton
