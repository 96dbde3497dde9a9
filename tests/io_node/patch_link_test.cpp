#include "io_node/patch_link.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/force/force_method.h"
#include "tests/io_node/network_loop_fixture.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/made_scene.h"
#include "tests/support/patience.h"

namespace hapton {
namespace {

std::unique_ptr<Patch> floor_patch(std::uint32_t generation) {
  auto patch = std::make_unique<Patch>();
  patch->step = std::make_unique<TouchStep>(*make_method({}, scene_of(made::sheet(0.05, 0.0, 20))));
  patch->radius_m = 1.0;
  patch->lift_m = 1e-7;
  patch->generation = generation;
  return patch;
}

// A network loop that may work with patches, and what it tells the haptics node about them.
struct PatchLinks : NetworkLoops {
  LocalPatch local;
  PatchThread thread{local};
  std::unique_ptr<PatchLink> link;

  void start(TouchChoice choice) {
    link = std::make_unique<PatchLink>(peers, local, thread, choice);
    make();
    network->set_patch_link(link.get());
    join(kHaptics, NodeRole::haptics);
    run(100);
  }
  // Starts with the hand 2 mm above the haptics node's floor, without contact.
  void start_above_floor(TouchChoice choice) {
    device.place = Vec3(0.001, 0.002, 0.002);
    floor_z_m = 0.0;
    force_reply.force_n = Vec3::Zero();
    force_reply.contact = false;
    start(choice);
    network->device_loop().set_local_touch(&local);
  }
  // True: the patch thread has handled everything that it was told so far, for example that a node joined. It takes everything in order,
  // and counts a part that belongs to no epoch as rejected; such a part changes nothing.
  bool thread_has_caught_up() {
    const std::uint64_t before = thread.counts().store.rejected;
    thread.push(PatchTile{});
    return wait_until([&] { return thread.counts().store.rejected > before; });
  }
  void offer_floor(std::uint32_t generation) {
    ASSERT_TRUE(thread_has_caught_up());
    local.set_generation(generation);
    local.offer(floor_patch(generation));
  }
};

TEST_F(PatchLinks, RemoteForceWantsNoParts) {
  start(TouchChoice::remote);
  run(500);
  EXPECT_TRUE(patch_statuses.empty());
  EXPECT_FALSE(link->is_wanted());
}

// Or sooner, if the patch thread has news. Its first news is that it has no parts.
TEST_F(PatchLinks, PatchesAreRequestedEvery100Ms) {
  start(TouchChoice::patch);
  patch_statuses.clear();
  run(1000);
  EXPECT_TRUE(link->is_wanted());
  ASSERT_GE(patch_statuses.size(), 9U);
  EXPECT_LE(patch_statuses.size(), 12U);
  for (const auto& [time_ns, status] : patch_statuses) EXPECT_TRUE(status.is_wanted);
  for (std::size_t i = 1; i < patch_statuses.size(); ++i) {
    const std::int64_t between_ns = patch_statuses[i].first - patch_statuses[i - 1].first;
    EXPECT_GE(between_ns, PatchLink::kMinStatusNs - 2 * kMs);
    EXPECT_LE(between_ns, PatchLink::kStatusNs + 2 * kMs);
  }
}

TEST_F(PatchLinks, AutomaticGoesByTheRoundTrip) {
  start(TouchChoice::automatic);
  run(2000);
  EXPECT_FALSE(link->is_wanted()) << "the round trip is 100 us";
  reply_delay_ns = static_cast<std::int64_t>(2e9 * TouchChooser::kSlowS);
  run(2000);
  EXPECT_TRUE(link->is_wanted());
  ASSERT_FALSE(patch_statuses.empty());
  EXPECT_NEAR(patch_statuses.back().second.round_trip_s, 2.0 * TouchChooser::kSlowS, 0.2 * TouchChooser::kSlowS);
  // The network is fast again: patches stay in use until it has been fast for a while; then the hub tells the haptics node.
  reply_delay_ns = 100 * kUs;
  run(2000);
  EXPECT_TRUE(link->is_wanted());
  run(4000);
  EXPECT_FALSE(link->is_wanted());
  EXPECT_FALSE(patch_statuses.back().second.is_wanted);
}

// Whoever runs the hub sees why the force is late or not, and since when.
TEST_F(PatchLinks, TheLogHasOneLineForEachChangeOfTheSource) {
  const auto take_source_events = [&] {
    std::vector<std::pair<ServoEvent::Kind, double>> events;
    for (ServoEvent event; network->events().pop(event);) {
      const bool is_source_change = event.kind == ServoEvent::Kind::parts_requested || event.kind == ServoEvent::Kind::force_from_parts ||
                                    event.kind == ServoEvent::Kind::force_from_haptics;
      if (is_source_change) events.emplace_back(event.kind, event.round_trip_s);
    }
    return events;
  };
  start(TouchChoice::automatic);
  run(2000);
  EXPECT_TRUE(take_source_events().empty()) << "a fast network";
  reply_delay_ns = 30 * kMs;
  run(4000);
  const auto slow = take_source_events();
  ASSERT_EQ(slow.size(), 1U);
  EXPECT_EQ(slow[0].first, ServoEvent::Kind::parts_requested);
  EXPECT_NEAR(slow[0].second, 0.030, 0.003);
  reply_delay_ns = 100 * kUs;
  run(8000);
  const auto fast = take_source_events();
  ASSERT_EQ(fast.size(), 1U) << "no parts came, so the force was never computed here";
  EXPECT_EQ(fast[0].first, ServoEvent::Kind::force_from_haptics);
  EXPECT_LT(fast[0].second, TouchChooser::kFastS);
}

// The haptics node is there, and its replies come too late: a person who searches for a missing node would search in the wrong place.
TEST_F(PatchLinks, RepliesThatComeTooLateAreNamedAsTheReason) {
  start(TouchChoice::remote);
  run(2000);
  EXPECT_FALSE(stats().are_replies_late());
  reply_delay_ns = 40 * kMs;
  run(2000);
  EXPECT_EQ(stats().status, ProbeStatus::no_haptics);
  EXPECT_TRUE(stats().are_replies_late());
  EXPECT_NEAR(stats().newest_round_trip_s, 0.040, 0.003);
  reply_delay_ns = 100 * kUs;
  run(2000);
  EXPECT_EQ(stats().status, ProbeStatus::ok);
  EXPECT_FALSE(stats().are_replies_late());
  reply_delay_ns = -1;
  run(500);
  EXPECT_EQ(stats().status, ProbeStatus::no_haptics);
  EXPECT_FALSE(stats().are_replies_late()) << "it does not reply at all";
}

// Slow for less than half of 3.2 s (find_lasting_round_trip_s): the moves of programs, recordings and the datagrams stay as before.
TEST_F(PatchLinks, ANetworkThatIsSlowForAMomentChangesNothing) {
  start(TouchChoice::automatic);
  run(4000);
  for (const int slow_ms : {200, 1000, 1400}) {
    reply_delay_ns = 40 * kMs;
    run(slow_ms);
    reply_delay_ns = 100 * kUs;
    for (int n = 0; n < 40; ++n) {
      run(100);
      ASSERT_FALSE(link->is_wanted()) << slow_ms << " ms, and " << 100 * n << " ms after it";
    }
  }
  EXPECT_TRUE(patch_statuses.empty());
  reply_delay_ns = 40 * kMs;
  run(1800);
  EXPECT_TRUE(link->is_wanted());
}

// However the round trip swings, the force becomes remote again only after it was below kFastS for kSettledNs: so changes are seldom.
TEST_F(PatchLinks, ARoundTripThatSwingsAroundTheLimitsChangesTheSourceSeldom) {
  start(TouchChoice::automatic);
  for (const int half_period_ms : {50, 700, 1900, 2900}) {
    reply_delay_ns = 100 * kUs;  // each pass begins with remote force
    run(8000);
    int changes = 0;
    bool was_wanted = link->is_wanted();
    ASSERT_FALSE(was_wanted);
    for (int n = 0; n < 40'000; n += 50) {
      reply_delay_ns = (n / half_period_ms) % 2 == 0 ? 3 * kMs : 12 * kMs;
      run(50);
      changes += link->is_wanted() != was_wanted ? 1 : 0;
      was_wanted = link->is_wanted();
    }
    EXPECT_LE(changes, 1) << half_period_ms << " ms fast, then as long slow";
  }
}

// A hub that wants parts and gets none: the force is remote, and its round trip matters.
TEST_F(PatchLinks, WithoutPatchesTheHapticsNodeLearnsOfTheRoundTrip) {
  reply_delay_ns = 2 * static_cast<std::int64_t>(1e9 * TouchChooser::kSlowS);
  start(TouchChoice::automatic);
  run(5000);
  EXPECT_TRUE(link->is_wanted());
  ASSERT_GE(loop_facts.size(), 3U);
  EXPECT_NEAR(loop_facts.back().round_trip_s, 2.0 * TouchChooser::kSlowS, 0.2 * TouchChooser::kSlowS);
}

// The hand presses 2 mm into the haptics node's floor while patches are wanted. The remote force goes on until a patch is there, and also
// when patches start again.
TEST_F(PatchLinks, TheRemoteForceGoesOnUntilAPatchIsThere) {
  start_above_floor(TouchChoice::patch);
  ASSERT_TRUE(thread_has_caught_up());
  local.set_generation(7);
  run(300);
  device.place.z() = -0.002;
  force_reply.force_n = Vec3(0, 0, 2);
  force_reply.contact = true;
  run(300);
  EXPECT_NEAR(device.written.back().force_n.z(), 2.0, 1e-6);
  const auto least_force_n_in = [&](int cycles) {
    const std::size_t before = device.written.size();
    run(cycles);
    double least_n = 1e9;
    for (std::size_t n = before; n < device.written.size(); ++n) least_n = std::min(least_n, device.written[n].force_n.z());
    return least_n;
  };
  EXPECT_GT(least_force_n_in(3000), 1.999);
  const std::uint64_t before = stats().local_forces;
  EXPECT_EQ(before, 0U);
  local.offer(floor_patch(7));
  EXPECT_GT(least_force_n_in(1000), 1.999) << "a patch takes over";
  EXPECT_GT(stats().local_forces, 900U);
  states.clear();
  local.set_generation(8);
  EXPECT_GT(least_force_n_in(1000), 1.999) << "patches start again";
  EXPECT_GT(std::count_if(states.begin(), states.end(), [](const DeviceState& state) { return state.is_resumed; }), 0)
      << "the haptics node goes on where the patches' probe was";
  local.free_retired();
  local.offer(floor_patch(8));
  EXPECT_GT(least_force_n_in(1000), 1.999);
  EXPECT_GT(stats().local_forces, 1900U);
  EXPECT_EQ(stats().governor.counters.command_timeouts, 0U);
}

// While the force was remote, the haptics node may have got another scene or method, for which earlier patches are wrong.
TEST_F(PatchLinks, PatchesFromBeforeAPauseAreNotUsedAfterIt) {
  reply_delay_ns = 12 * kMs;
  start_above_floor(TouchChoice::automatic);
  run(1000);
  ASSERT_TRUE(link->is_wanted());
  offer_floor(77);
  run(500);
  EXPECT_GT(stats().local_forces, 300U);
  reply_delay_ns = 100 * kUs;
  run(7000);
  ASSERT_FALSE(link->is_wanted());
  const std::uint64_t local_forces_before = stats().local_forces;
  reply_delay_ns = 12 * kMs;
  run(3000);
  ASSERT_TRUE(link->is_wanted());
  EXPECT_EQ(stats().local_forces, local_forces_before);
  ASSERT_TRUE(thread_has_caught_up());
  local.free_retired();
  local.set_generation(78);
  local.offer(floor_patch(78));
  run(500);
  EXPECT_GT(stats().local_forces, local_forces_before + 300);
}

// Otherwise the device side would compute a force in each cycle until the very end, where the force then drops in one step.
TEST_F(PatchLinks, AtTheEndOfTheSessionNoPatchIsFelt) {
  start_above_floor(TouchChoice::patch);
  offer_floor(7);
  run(300);
  device.place.z() = -0.002;
  run(300);
  EXPECT_GT(peers.haptics_timeout_ns(), HubPeers::kHapticsTimeoutNs) << "it gets few states meanwhile";
  const DeviceSample sample{.time_ns = clock.now_ns(), .p_WD = device.place};
  EXPECT_TRUE(local.step(sample));
  network->finish();
  EXPECT_FALSE(local.step(sample));
}

// The hand stays 2 mm below the floor, and only the hub knows this contact. The patches of the former node are not felt. A first patch of
// the new node is not felt as if the hand were free either: contact would be lost for good.
TEST_F(PatchLinks, ContactOutlivesAHapticsNodeWhosePatchesWereFelt) {
  start_above_floor(TouchChoice::patch);
  offer_floor(7);
  run(300);
  device.place.z() = -0.002;
  run(300);
  EXPECT_NEAR(device.written.back().force_n.z(), 2.0, 1e-6);
  const std::uint64_t local_forces_before = stats().local_forces;
  EXPECT_GT(local_forces_before, 500U);
  say(kHaptics, Bye{});
  sequences.erase(kHaptics);
  run(1500);
  EXPECT_EQ(device.written.back().force_n, Vec3(Vec3::Zero()));

  reply_delay_ns = -1;
  states.clear();
  join(kHaptics, NodeRole::haptics);
  run(20);
  // The patch thread has dropped what it had, and one patch of the new node is there before its first reply.
  ASSERT_TRUE(thread_has_caught_up());
  local.set_generation(9);
  local.free_retired();
  local.offer(floor_patch(9));
  run(300);
  EXPECT_NEAR(device.written.back().force_n.z(), 2.0, 1e-6) << stats().local_forces - local_forces_before;
  ASSERT_FALSE(states.empty());
  EXPECT_TRUE(states.front().is_resumed);
  EXPECT_NEAR(states.front().p_WP.z(), 0.0, 1e-6);
}

// A hub that was started again knows of no contact, but the haptics node does. That node's first reply may come after its first patch.
TEST_F(PatchLinks, APatchOfAHapticsNodeThatHasNotRepliedIsNotFelt) {
  device.place = Vec3(0.001, 0.002, -0.002);
  floor_z_m = 0.0;
  force_reply.force_n = Vec3(0, 0, 2);
  force_reply.contact = true;
  reply_delay_ns = -1;
  start(TouchChoice::patch);
  network->device_loop().set_local_touch(&local);
  offer_floor(7);
  run(300);
  EXPECT_EQ(stats().local_forces, 0U);
  reply_delay_ns = 100 * kUs;
  run(300);
  EXPECT_NEAR(device.written.back().force_n.z(), 2.0, 1e-6);
  EXPECT_GT(stats().local_forces, 200U);
}

TEST_F(PatchLinks, WithoutAHapticsNodeNothingIsWanted) {
  start(TouchChoice::patch);
  EXPECT_TRUE(link->is_wanted());
  say(kHaptics, Bye{});
  sequences.erase(kHaptics);
  run(300);
  EXPECT_FALSE(link->is_wanted());
}

TEST_F(PatchLinks, PartsThatWereNotRequestedAreDropped) {
  start(TouchChoice::remote);
  PatchTile tile;
  tile.epoch = tile.serial = 1;
  for (int n = 0; n < 50; ++n) say(kHaptics, tile);
  run(100);
  ASSERT_TRUE(thread_has_caught_up());
  EXPECT_EQ(link->thread_counts().store.parts + link->thread_counts().store.rejected, 1U) << "only the part with which it caught up";
}

// Also sends a beginning of parts, and counts the parts that the patch thread has taken once it has caught up.
struct PatchRequests : PatchLinks {
  std::uint32_t request() const { return patch_statuses.back().second.request; }
  std::uint64_t parts_after(const PatchBegin& begin) {
    say(kHaptics, begin);
    run(10);
    EXPECT_TRUE(thread_has_caught_up());
    return thread.counts().store.parts;
  }
};

// Parts that were sent before the hub dropped its own parts come too late to be used.
TEST_F(PatchRequests, AnEpochForAnEarlierRequestIsNotUsed) {
  start(TouchChoice::patch);
  ASSERT_FALSE(patch_statuses.empty());
  const std::uint32_t earlier_request = request();
  EXPECT_NE(earlier_request, 0U);
  PatchBegin begin{.epoch = 1, .serial = 1, .step_m = 1e-6, .request = earlier_request};
  EXPECT_EQ(parts_after(begin), 1U);
  say(kHaptics, Bye{});
  sequences.erase(kHaptics);
  run(100);
  join(kHaptics, NodeRole::haptics);
  run(200);
  EXPECT_NE(request(), earlier_request);
  ASSERT_TRUE(thread_has_caught_up());
  begin.epoch = 7;
  EXPECT_EQ(parts_after(begin), 1U);
  begin.request = request();
  EXPECT_EQ(parts_after(begin), 2U);
  begin.epoch = 8;
  begin.request = 0;
  EXPECT_EQ(parts_after(begin), 3U) << "of a haptics node that knows of no requests";
}

// Otherwise a haptics node that withdraws its parts would wait for ever if the message that they are not wanted was lost.
TEST_F(PatchRequests, ASenderOfUnwantedPartsIsNotified) {
  start(TouchChoice::remote);
  run(300);
  ASSERT_TRUE(patch_statuses.empty());
  for (int n = 0; n < 20; ++n) {
    say(kHaptics, PatchBegin{.epoch = 1, .serial = 1, .step_m = 1e-6});
    run(5);
  }
  ASSERT_GE(patch_statuses.size(), 1U);
  EXPECT_LE(patch_statuses.size(), 3U) << "not for each";
  EXPECT_FALSE(patch_statuses.back().second.is_wanted);
  EXPECT_EQ(patch_statuses.back().second.epoch, 0U);
  run(100);
  patch_statuses.clear();
  run(500);
  EXPECT_TRUE(patch_statuses.empty());
}

// An object was put down where the hand is. The place that the haptics node's probe had before may now be inside this object.
TEST_F(PatchRequests, TheFirstPatchWaitsForAReplyThatKnowsOfTheScene) {
  device.place = Vec3(0.001, 0.002, -0.002);
  floor_z_m = 0.0;
  force_reply.contact = true;
  force_reply.method_serial = 4;
  start(TouchChoice::patch);
  network->device_loop().set_local_touch(&local);
  run(300);
  // The bodies (body_count) are never announced, so the patch thread itself makes no patch.
  EXPECT_EQ(parts_after({.epoch = 1, .serial = 1, .step_m = 1e-6, .body_count = 2, .request = request(), .method_serial = 5}), 1U);
  local.set_generation(7);
  local.offer(floor_patch(7));
  run(500);
  EXPECT_EQ(stats().local_forces, 0U);
  force_reply.method_serial = 5;
  run(300);
  EXPECT_GT(stats().local_forces, 250U) << "without the pause between two places of the probe";
  EXPECT_NEAR(device.written.back().force_n.z(), 2.0, 1e-6);
  // An older epoch (the numbers of epochs wrap around) that comes late changes nothing.
  say(kHaptics, PatchBegin{.epoch = 0xFFFFFFF0, .serial = 1, .step_m = 1e-6, .request = request(), .method_serial = 9});
  const std::uint64_t before = stats().local_forces;
  run(300);
  EXPECT_GE(stats().local_forces, before + 299);
  // The device side learns of a newer epoch at once, before the patch thread can make anything of it.
  const DeviceSample sample{.time_ns = clock.now_ns(), .p_WD = device.place};
  EXPECT_TRUE(local.step(sample));
  link->accept(PatchBegin{.epoch = 2, .serial = 1, .step_m = 1e-6, .request = request(), .method_serial = 6});
  EXPECT_FALSE(local.step(sample));
}

// While the device side computes the force, the haptics node gets 20 samples a second, but a button picks up what is touched just then.
TEST_F(PatchRequests, AButtonIsKnownToTheHapticsNodeAtOnce) {
  device.place = Vec3(0.001, 0.002, 0.002);
  floor_z_m = 0.0;
  device.stylus_buttons = 0;
  start(TouchChoice::patch);
  network->device_loop().set_local_touch(&local);
  offer_floor(7);
  run(300);
  ASSERT_GT(stats().local_forces, 200U);
  for (const std::uint32_t down : {1U, 0U, 2U}) {
    run(7);
    states.clear();
    device.stylus_buttons = down;
    run(3);
    ASSERT_GE(states.size(), 1U);
    EXPECT_EQ(states.front().buttons, down);
    states.clear();
    run(1000);
    EXPECT_NEAR(static_cast<double>(states.size()), 20.0, 2.0);
  }
}

// The first patch starts where the former haptics node had the probe, if the new node has put nothing down. Otherwise that place means
// nothing, however many changes of the method the former node had counted.
TEST_F(PatchRequests, TheProbeOfTheFormerHapticsNodeIsNotUsedAsAReply) {
  device.place = Vec3(0.001, 0.002, -0.002);
  floor_z_m = 0.0;
  force_reply.contact = true;
  force_reply.method_serial = 9;
  start(TouchChoice::patch);
  network->device_loop().set_local_touch(&local);
  run(300);
  say(kHaptics, Bye{});
  sequences.erase(kHaptics);
  run(300);
  reply_delay_ns = -1;
  join(kHaptics, NodeRole::haptics);
  run(20);
  ASSERT_TRUE(thread_has_caught_up());
  EXPECT_EQ(parts_after({.epoch = 1, .serial = 1, .step_m = 1e-6, .body_count = 2, .request = request(), .method_serial = 5}), 1U);
  local.set_generation(7);
  local.offer(floor_patch(7));
  run(300);
  EXPECT_EQ(stats().local_forces, 0U);
  reply_delay_ns = 100 * kUs;
  force_reply.method_serial = 4;
  run(300);
  EXPECT_EQ(stats().local_forces, 0U);
  force_reply.method_serial = 5;
  run(300);
  EXPECT_GT(stats().local_forces, 250U);
  EXPECT_NEAR(device.written.back().force_n.z(), 2.0, 1e-6);
}

TEST_F(PatchRequests, AcceptingABeginningOfPartsUsesNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  start(TouchChoice::patch);
  ASSERT_TRUE(thread_has_caught_up());
  Message message = PatchBegin{.serial = 1, .step_m = 1e-6};
  auto& begin = std::get<PatchBegin>(message);
  const AllocationGuard guard;
  for (std::uint32_t n = 1; n <= 100; ++n) {
    begin.epoch = begin.method_serial = n;
    begin.request = n % 2 == 0 ? request() : request() + 2;
    link->accept(message);
  }
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace hapton
