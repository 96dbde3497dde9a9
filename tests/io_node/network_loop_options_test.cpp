// The options of a network loop reach the device side.
#include <gtest/gtest.h>

#include <vector>

#include "tests/io_node/network_loop_fixture.h"

namespace hapton {
namespace {

TEST_F(NetworkLoops, TheClutchOfItsOptionsHoldsTheDevicePointAndTakesTheForceAway) {
  device.stylus_buttons = 0;
  make({.clutch_button = 2});
  join(kHaptics, NodeRole::haptics);
  run(300);
  ASSERT_EQ(device.written.back().force_n, force_reply.force_n);
  device.stylus_buttons = 2;
  run(1);
  const Vec3 pressed_at = device.place;
  device.drift = Vec3(-1e-4, 0, 0);
  run(50);
  EXPECT_EQ(states.back().p_WD, pressed_at);
  EXPECT_EQ(device.written.back().force_n, Vec3::Zero());
}

// The hand moves in the direction of the force, so the force would give it energy all the time.
TEST_F(NetworkLoops, ThePassivityControllerIsOnWhereItsMechanicsAreGiven) {
  device.drift = Vec3(0, 0, 1e-4);
  make({.passive_mechanics = PassivityController::Mechanics{.mass_kg = 0.1}});
  join(kHaptics, NodeRole::haptics);
  run(200);
  EXPECT_GT(stats().forces, 150U);
  EXPECT_GT(stats().governor.counters.kept_passive, 100U);
  EXPECT_LT(stats().max_force_n, 0.1);
}

TEST_F(NetworkLoops, ATorqueReachesTheMotorsWithinItsOwnLimitOrNotAtAll) {
  device.give_torque(0.2);
  force_reply.torque_nm = Vec3(0.1, 0, 0);
  make({.tighter_limits = {.max_torque_nm = 0.05}});
  join(kHaptics, NodeRole::haptics);
  run(300);
  EXPECT_NEAR(stats().max_torque_nm, 0.05, 1e-9);
  make({.forbids_torque = true});
  run(300);
  EXPECT_EQ(stats().max_torque_nm, 0.0);
  EXPECT_EQ(device.written.back().force_n, force_reply.force_n);
}

TEST_F(NetworkLoops, AMissedCycleThatStopsTheSessionIsRecordedAsItsFault) {
  RecordingTap tap;
  make({.overrun = OverrunPolicy::stop}, nullptr, &tap);
  run(100);
  EXPECT_TRUE(tap.faults.empty());
  clock.advance_ns(3 * kMs);
  run(2);
  EXPECT_EQ(tap.faults, std::vector{SessionFault::overrun});
  peers.set_tap(nullptr);
}

}  // namespace
}  // namespace hapton
