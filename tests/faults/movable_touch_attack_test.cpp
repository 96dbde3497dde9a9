// As movable_touch_test.cpp: a hand that touches something else, and one that does not rest.
#include <cstdlib>
#include <string>

#include "tests/faults/movable_touch_stage.h"

namespace hapton {
namespace {

// A vision node takes a pick-up back while the hand presses on something else: it goes on doing so.
TEST_F(MovableTouch, AHandOnWhatStaysKeepsItsContact) {
  const Vec3 on_plate(-0.03, -0.03, -0.002);
  for (const int delay_ms : {6, 30, -30}) {
    SCOPED_TRACE(delay_ms);
    // The reply to the first sample after the hub has dropped its parts is late: until then the hub has confirmed that.
    builds_on_approach = delay_ms < 0;
    moved = Vec3::Zero();
    checked = 0;
    ASSERT_NO_FATAL_FAILURE(press(170, {.delay_ns = std::abs(delay_ms) * kMs}));
    system->device.led = kPressed + Vec3(0, 0, 0.03);
    system->run_for_ns(800 * kMs);
    system->device.led = on_plate + Vec3(0, 0, 0.03);
    system->run_for_ns(2000 * kMs);
    system->device.led = on_plate;
    system->run_for_ns(1500 * kMs);
    ASSERT_TRUE(system->wait_for_patches());
    ASSERT_NEAR(system->touched.back().force.force_n.z(), 2.0, kOnGridN);
    const auto vision = system->make_vision(1);
    system->run_for_ns(200 * kMs);
    const std::uint32_t serial = grasp().poses()[kBlock].serial;
    vision->send(ObjectPose{.serial = serial, .object = kBlock, .p_m = kCarried});
    ASSERT_TRUE(system->wait_until([&] { return grasp().poses()[kBlock].serial != serial && !grasp().is_busy(); }));
    checked = system->touched.size();
    ASSERT_TRUE(system->wait_for_patches());
    system->run_for_ns(300 * kMs);
    EXPECT_TRUE(system->touched.back().force.contact);
    EXPECT_EQ(system->touched.back().force.object, 0);
    EXPECT_NEAR(system->touched.back().force.force_n.z(), 2.0, kOnGridN);
    EXPECT_NEAR(system->force_n().z(), 2.0, 1e-3);
  }
}

// The hand goes on into the object that it has released. It is held from where it touched the object, if it stays within a resume's reach
// of that; otherwise it begins inside, without a force, whoever computes it.
TEST_F(MovableTouch, AHandThatIsFastAsItReleasesIsHeldAsWithRemoteForce) {
  for (const TouchChoice choice : {TouchChoice::remote, TouchChoice::patch}) {
    for (const double deep_m : {0.004, 0.9 * kResumeReachM, 1.2 * kResumeReachM}) {
      SCOPED_TRACE(std::to_string(deep_m) + (choice == TouchChoice::remote ? " m, remote" : " m, from patches"));
      moved = Vec3::Zero();
      checked = 0;
      ASSERT_NO_FATAL_FAILURE(press(171, choice == TouchChoice::remote ? LinkFaults{} : kFar, choice));
      ASSERT_NO_FATAL_FAILURE(pick_up());
      carry(kPressed + Vec3(0, 0, 0.03));
      // The pose of the object comes from a thread of its own.
      int turns = 0;
      (void)system->wait_until([&] { return ++turns > 50; });
      // At 1 m/s down, then to that depth in the object; the button is released on the way.
      system->device.led_m = 1e-3;
      system->device.led = kPressed + Vec3(0, 0, -0.02);
      system->run_for_ns(5 * kMs);
      system->device.buttons = 0;
      while (grasp().tool() != nullptr) system->run_for_ns(kMs);
      moved = grasp().poses()[kBlock].p_m;
      const double below_m = deep_m - 0.002;
      system->device.led = kPressed + moved - Vec3(0, 0, below_m);
      system->run_for_ns(200 * kMs);
      const bool is_held = deep_m < kResumeReachM;
      // The scene may be there before the hand is, on a machine that stands still meanwhile: then that is not known.
      if (!is_held && !grasp().is_busy()) continue;
      ASSERT_TRUE(system->wait_until([&] { return !grasp().is_busy(); }));
      if (choice == TouchChoice::patch) {
        ASSERT_TRUE(system->wait_for_patches());
      }
      system->run_for_ns(300 * kMs);
      const double wanted_n = kBlockStiffness * deep_m;
      if (wanted_n < 5.0 || !is_held) {
        EXPECT_NEAR(system->force_n().z(), is_held ? wanted_n : 0.0, 1e-3);
      }
      EXPECT_EQ(system->force_n().z() > 1.0, is_held);
      if (choice == TouchChoice::patch) {
        EXPECT_EQ(system->touched.back().force.contact, is_held);
      }
    }
  }
}

}  // namespace
}  // namespace hapton
