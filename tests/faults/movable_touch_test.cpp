// A scene with an object that can be picked up, felt from patches across a slow and a bad network. Times are simulated; only the threads
// that send and build patches, make the tool and build the scene run in real time.
#include "tests/faults/movable_touch_stage.h"

namespace hapton {
namespace {

TEST_F(MovableTouch, AnObjectIsFeltFromPatchesWhereItLies) {
  ASSERT_NO_FATAL_FAILURE(press(161, kFarLink));
  ASSERT_NO_FATAL_FAILURE(pick_up());
  carry(kPressed + kCarried);
  ASSERT_NO_FATAL_FAILURE(put_down());
  EXPECT_LT((displacement_m - kCarried).norm(), 1e-9);
  EXPECT_NEAR(system->local_steps.back().force.force_n.z(), 2.0, kGridRoundingN) << "the hand is on it, as when it was picked up";
  ASSERT_NO_FATAL_FAILURE(feel_both_places());
  // The hand picks the block up again at its new place.
  ASSERT_NO_FATAL_FAILURE(pick_up());
  carry(kPressed);
  ASSERT_NO_FATAL_FAILURE(put_down());
  EXPECT_LT(displacement_m.norm(), 1e-9);
  lead(kPressed);
  EXPECT_NEAR(system->local_steps.back().force.force_n.z(), 2.0, kGridRoundingN);
}

// Datagrams of the old place come late, twice, after those of the new one, or never.
TEST_F(MovableTouch, NothingOfTheOldPlaceIsFeltHoweverBadTheNetworkIs) {
  for (std::uint64_t seed = 1610; seed < 1616; ++seed) {
    SCOPED_TRACE(seed);
    const bool is_slow = seed % 2 == 0;
    displacement_m = Vec3::Zero();
    checked_count = 0;
    ASSERT_NO_FATAL_FAILURE(
        press(seed, {.delay_ns = (is_slow ? 120 : 12) * kMs, .jitter_ns = (is_slow ? 200 : 30) * kMs, .loss = 0.25, .duplicate = 0.3}));
    ASSERT_NO_FATAL_FAILURE(pick_up());
    carry(kPressed + kCarried);
    ASSERT_NO_FATAL_FAILURE(put_down());
    ASSERT_NO_FATAL_FAILURE(feel_both_places());
  }
}

// A button that is pressed for a moment only moves nothing, and the hand keeps its contact.
TEST_F(MovableTouch, AShortPressMovesNothing) {
  ASSERT_NO_FATAL_FAILURE(press(162, kFarLink));
  for (const int ms : {1, 20, 70, 110}) {
    system->device.buttons = 1;
    system->run_for_ns(ms * kMs);
    system->device.buttons = 0;
    system->run_for_ns(300 * kMs);
    ASSERT_TRUE(system->wait_until([&] { return !grasp().is_busy(); }));
    ASSERT_TRUE(system->wait_for_patches());
    displacement_m = grasp().poses()[kBlock].p_m;
    ASSERT_LT(displacement_m.norm(), 1e-9);
    lead(kPressed);
    EXPECT_NEAR(system->local_steps.back().force.force_n.z(), 2.0, kGridRoundingN) << ms;
  }
}

// The hub is started again while the object is held, and while it is about to be picked up. The new hub gets only the new place.
TEST_F(MovableTouch, AHubThatIsStartedAgainFeelsItWhereItIs) {
  for (const int after_ms : {0, 20, 50, 80, 300}) {
    SCOPED_TRACE(after_ms);
    displacement_m = Vec3::Zero();
    checked_count = 0;
    ASSERT_NO_FATAL_FAILURE(press(163, kFarLink));
    system->device.buttons = 1;
    system->run_for_ns(after_ms * kMs);
    system->start_hub();
    system->run_for_ns(500 * kMs);
    ASSERT_TRUE(expect_block());
    // If the hub to which the button was pressed ended before the object could be picked up, the button is pressed again.
    if (!grasp().is_busy()) {
      system->device.buttons = 0;
      system->run_for_ns(100 * kMs);
    }
    ASSERT_NO_FATAL_FAILURE(pick_up());
    carry(kPressed + kCarried);
    ASSERT_NO_FATAL_FAILURE(put_down());
    ASSERT_NO_FATAL_FAILURE(feel_both_places());
  }
}

// A vision node undoes a pick-up: the hub drops its patches before the object is moved.
TEST_F(MovableTouch, AnObjectThatIsRequestedToBeElsewhereIsFeltThere) {
  ASSERT_NO_FATAL_FAILURE(press(164, kFarLink));
  lead(kPressed + Vec3(0, 0, 0.02));
  const auto vision = system->make_vision(1);
  system->run_for_ns(200 * kMs);
  const std::uint32_t serial = grasp().poses()[kBlock].serial;
  ASSERT_TRUE(system->wait_until([&] {
    if (grasp().poses()[kBlock].serial == serial) vision->send(ObjectPose{.serial = serial, .object = kBlock, .p_m = kCarried});
    return grasp().poses()[kBlock].serial != serial;
  }));
  ASSERT_TRUE(expect_block());
  const std::size_t before = checked_count;
  ASSERT_TRUE(system->wait_until([&] { return !grasp().is_busy(); }));
  EXPECT_EQ(system->local_steps.size(), before);
  displacement_m = kCarried;
  ASSERT_TRUE(system->wait_for_patches());
  ASSERT_NO_FATAL_FAILURE(feel_both_places());
}

// With one round trip, remote force is used; with the other, a held object is not felt. In the worst case, two forces fade at once.
TEST_F(MovableTouch, TheForceHasNoJump) {
  for (const int delay_ms : {6, 30}) {
    SCOPED_TRACE(delay_ms);
    displacement_m = Vec3::Zero();
    checked_count = 0;
    ASSERT_NO_FATAL_FAILURE(press(165, {.delay_ns = delay_ms * kMs}, TouchChoice::automatic));
    std::size_t n = system->device.written.size();
    ASSERT_NO_FATAL_FAILURE(pick_up());
    carry(kPressed + kCarried);
    EXPECT_NEAR(system->force_n().norm(), 0.0, 1e-3) << "held in the air";
    ASSERT_NO_FATAL_FAILURE(put_down());
    lead(kPressed + displacement_m);
    EXPECT_NEAR(system->force_n().z(), 2.0, 1e-3);
    double fastest_n_per_s = 0.0;
    for (; n < system->device.written.size(); ++n) {
      const PressingDevice::Written& now = system->device.written[n];
      const PressingDevice::Written& before = system->device.written[n - 1];
      const double passed_s = std::max(1e-3, 1e-9 * static_cast<double>(now.time_ns - before.time_ns));
      fastest_n_per_s = std::max(fastest_n_per_s, (now.force_n - before.force_n).norm() / passed_s);
    }
    // 2 N fade, in the air and in contact; and a hand at 50 mm/s changes the force of a surface by 50 N/s.
    EXPECT_LT(fastest_n_per_s, 2.0 / ForceFade::kInAirS + 2.0 / ForceFade::kInContactS + 50.0);
  }
}

// A new haptics node has the scene as in its file, whatever the previous node was about to do.
TEST_F(MovableTouch, AHapticsNodeThatIsStartedAgainIsFeltAsItHasTheScene) {
  for (const int after_ms : {20, 70, 300}) {
    SCOPED_TRACE(after_ms);
    displacement_m = Vec3::Zero();
    checked_count = 0;
    ASSERT_NO_FATAL_FAILURE(press(166, kFarLink));
    system->device.buttons = 1;
    system->run_for_ns(after_ms * kMs);
    system->kill_haptics();
    ASSERT_TRUE(expect_block());
    system->device.buttons = 0;
    system->device.target = kPressed + Vec3(0, 0, 0.02);
    system->run_for_ns(500 * kMs);
    system->start_haptics();
    ASSERT_TRUE(system->wait_for_patches());
    lead(kPressed);
    ASSERT_NO_FATAL_FAILURE(pick_up());
    carry(kPressed + kCarried);
    ASSERT_NO_FATAL_FAILURE(put_down());
    ASSERT_NO_FATAL_FAILURE(feel_both_places());
  }
}

// The patches of the new place are still on their way, or have not been made yet, when the object leaves that place too.
TEST_F(MovableTouch, AnObjectThatIsPickedUpAgainAtOnceIsFeltWhereItLiesInTheEnd) {
  for (const int after_ms : {0, 10, 40, 100}) {
    SCOPED_TRACE(after_ms);
    displacement_m = Vec3::Zero();
    checked_count = 0;
    ASSERT_NO_FATAL_FAILURE(press(167, {.delay_ns = 30 * kMs, .jitter_ns = 20 * kMs, .loss = 0.1, .duplicate = 0.2}));
    ASSERT_NO_FATAL_FAILURE(pick_up());
    carry(kPressed + kCarried);
    system->device.buttons = 0;
    ASSERT_TRUE(system->wait_until([&] { return !grasp().is_busy(); }));
    EXPECT_EQ(system->local_steps.size(), checked_count);
    displacement_m = grasp().poses()[kBlock].p_m;
    system->run_for_ns(after_ms * kMs);
    ASSERT_NO_FATAL_FAILURE(pick_up());
    carry(kPressed + 0.5 * kCarried + Vec3(0, -0.03, 0));
    ASSERT_NO_FATAL_FAILURE(put_down());
    ASSERT_NO_FATAL_FAILURE(feel_both_places());
  }
}

// The hub stops using patches, and requests them again later: it has dropped the old ones, and gets patches of the new place.
TEST_F(MovableTouch, AnObjectThatMovesWhileTheForceIsRemoteIsFeltWhereItIs) {
  const LinkFaults slow{.delay_ns = 12 * kMs, .jitter_ns = 10 * kMs, .duplicate = 0.3};
  for (const bool is_held : {true, false}) {
    SCOPED_TRACE(is_held);
    displacement_m = Vec3::Zero();
    checked_count = 0;
    ASSERT_NO_FATAL_FAILURE(press(169, slow, TouchChoice::automatic));
    if (is_held) {
      ASSERT_NO_FATAL_FAILURE(pick_up());
    }
    system->set_faults({}, {});
    ASSERT_TRUE(system->wait_until([&] { return !system->wants_patches(); }));
    ASSERT_TRUE(expect_block());
    if (!is_held) {
      ASSERT_NO_FATAL_FAILURE(pick_up());
    }
    carry(kPressed + kCarried);
    if (!is_held) {
      system->set_faults(slow, slow);
      ASSERT_TRUE(system->wait_until([&] { return system->wants_patches(); }));
    }
    system->run_for_ns(300 * kMs);
    system->device.buttons = 0;
    ASSERT_TRUE(system->wait_until([&] { return !grasp().is_busy(); }));
    EXPECT_EQ(system->local_steps.size(), checked_count);
    displacement_m = grasp().poses()[kBlock].p_m;
    system->set_faults(slow, slow);
    ASSERT_TRUE(system->wait_for_patches());
    ASSERT_NO_FATAL_FAILURE(feel_both_places());
  }
}

// While the link is down, the haptics node cannot know which patches the hub has, so no object leaves its place until it knows.
TEST_F(MovableTouch, APickUpWhileTheLinkIsDownWaitsForIt) {
  const LinkFaults down{.loss = 1.0};
  for (const bool is_one_way : {false, true}) {
    SCOPED_TRACE(is_one_way);
    displacement_m = Vec3::Zero();
    checked_count = 0;
    ASSERT_NO_FATAL_FAILURE(press(168, kFarLink));
    system->set_faults(down, is_one_way ? kFarLink : down);
    system->device.buttons = 1;
    system->run_for_ns(500 * kMs);
    ASSERT_TRUE(expect_block());
    EXPECT_NEAR(system->force_n().z(), 2.0, 1e-3) << "as long as the last message of the haptics node is recent";
    system->run_for_ns(2000 * kMs);
    ASSERT_TRUE(expect_block());
    EXPECT_EQ(grasp().tool(), nullptr);
    EXPECT_EQ(system->force_n(), Vec3(Vec3::Zero()));
    system->set_faults(kFarLink, kFarLink);
    system->run_for_ns(1000 * kMs);
    if (!grasp().is_busy()) {
      system->device.buttons = 0;
      ASSERT_TRUE(system->wait_for_patches());
      system->run_for_ns(200 * kMs);
    }
    ASSERT_NO_FATAL_FAILURE(pick_up());
    carry(kPressed + kCarried);
    ASSERT_NO_FATAL_FAILURE(put_down());
    ASSERT_NO_FATAL_FAILURE(feel_both_places());
  }
}

}  // namespace
}  // namespace hapton
