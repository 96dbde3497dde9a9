#include "io_node/network_loop.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include "link/bare_echo_endpoint.h"
#include "tests/io_node/network_loop_fixture.h"

namespace hapton {
namespace {

TEST_F(NetworkLoops, TicksOnAbsoluteTimeAndWritesTheMatchingForceAtOnce) {
  make();
  join(kHaptics, NodeRole::haptics);
  run(500);
  ASSERT_EQ(device.reads.size(), 500U);
  for (std::size_t n = 1; n < 500; ++n) ASSERT_EQ(device.reads[n] - device.reads[0], static_cast<std::int64_t>(n) * kMs);
  EXPECT_EQ(states.back().p_WD, device.place);
  EXPECT_EQ(states.back().buttons, 5U);
  EXPECT_EQ(device.written.back().force_n, force_reply.force_n);
  EXPECT_EQ(device.written.back().time_ns, states.back().sample_time_ns + 100 * kUs);
  EXPECT_EQ(stats().round_trip.max_ns(), 100 * kUs);
  EXPECT_EQ(stats().haptics_compute.max_ns(), 7 * kUs);
  EXPECT_EQ(stats().wire.max_ns(), 93 * kUs);
  EXPECT_EQ(stats().force_age.max_ns(), 100 * kUs);
  EXPECT_EQ(stats().wake_lateness.max_ns(), 0);
  EXPECT_EQ(stats().samples, 500U);
  EXPECT_EQ(stats().forces, states.size());
  EXPECT_EQ(stats().contact_samples, states.size());
  EXPECT_EQ(stats().responses.lost + stats().responses.late + stats().missed_cycles, 0U);
  EXPECT_NEAR(stats().seconds(), 0.5, 1e-12);
}

TEST_F(NetworkLoops, ADeviceThatIsAwayIsReportedAndItsForceRampsUpOnReturn) {
  make();
  join(kHaptics, NodeRole::haptics);
  run(300);
  for (const DeviceStatus status : {DeviceStatus::away, DeviceStatus::calibrating}) {
    device.device_status = status;
    run(500);
    EXPECT_EQ(device.written.back().force_n, Vec3::Zero());
    device.place.x() = -device.place.x();
    device.device_status = DeviceStatus::ready;
    run(20);
    EXPECT_LT(device.written.back().force_n.z(), 0.6);
    run(250);
    EXPECT_EQ(device.written.back().force_n, force_reply.force_n);
  }
  std::vector<ServoEvent::Kind> kinds;
  for (const ServoEvent& event : events_of(*network, {ServoEvent::Kind::away, ServoEvent::Kind::calibrating, ServoEvent::Kind::back})) {
    kinds.push_back(event.kind);
  }
  EXPECT_EQ(kinds, (std::vector{ServoEvent::Kind::away, ServoEvent::Kind::back, ServoEvent::Kind::calibrating, ServoEvent::Kind::back}));
  EXPECT_EQ(stats().governor.fault, SafetyFault::none);
}

TEST_F(NetworkLoops, TheDeadMansSwitchReleasesTheForce) {
  make({.dead_mans_switch = 2});
  join(kHaptics, NodeRole::haptics);
  run(300);  // buttons 1 and 3 of the device are held, counted from 1
  EXPECT_TRUE(device.written.empty() || device.written.back().force_n == Vec3::Zero());
  make({.dead_mans_switch = 3});
  run(300);
  EXPECT_EQ(device.written.back().force_n, force_reply.force_n);
  device.is_held = false;
  run(20);
  EXPECT_EQ(device.written.back().force_n, Vec3::Zero());
}

TEST_F(NetworkLoops, EchoIsMeasuredHalfwayAndLeavesTheForcePathAlone) {
  ScriptedEndpoint echo_endpoint(clock);
  const Address responder{{5}, 5};
  std::vector<std::int64_t> send_times_ns;
  echo_endpoint.on_send_raw = [&](const Address& to, std::span<const std::byte> bytes) {
    send_times_ns.push_back(clock.now_ns());
    std::vector<std::byte> reply(bytes.begin(), bytes.end());
    std::memcpy(reply.data(), kEchoReply.data(), kEchoMarkBytes);
    if (send_times_ns.size() % 10 != 0) echo_endpoint.arrive_raw(clock.now_ns() + 30 * kUs, to, reply);
  };
  EchoProbe echo(echo_endpoint, clock, responder);
  make({}, &echo);
  join(kHaptics, NodeRole::haptics);
  run(500);
  EXPECT_EQ(stats().round_trip.max_ns(), 100 * kUs);
  EXPECT_EQ(stats().wake_lateness.max_ns(), 0);
  EXPECT_EQ(stats().missed_cycles, 0U);
  EXPECT_EQ(send_times_ns.size(), 500U);
  for (std::size_t n = 0; n < send_times_ns.size(); ++n) ASSERT_EQ(send_times_ns[n] - device.reads[n], 500 * kUs);
  EXPECT_EQ(stats().echo.replied, 450U);
  EXPECT_EQ(stats().bare_echo.max_ns(), 30 * kUs);
}

TEST_F(NetworkLoops, FinishReleasesTheForce) {
  make();
  join(kHaptics, NodeRole::haptics);
  run(300);
  EXPECT_EQ(device.written.back().force_n, force_reply.force_n);
  network->finish();
  EXPECT_EQ(device.written.back().force_n, Vec3::Zero());
  EXPECT_EQ(stats().responses.lost, 0U);
  EXPECT_EQ(stats().governor.counters.command_timeouts, 0U);
  EXPECT_NEAR(stats().seconds(), 0.3, 1e-12);
}

TEST_F(NetworkLoops, AForceLimitOfZeroEndsTheForceAndNothingElse) {
  make({.forbids_force = true});
  join(kHaptics, NodeRole::haptics);
  run(300);
  EXPECT_EQ(stats().max_force_n, 0.0);
  EXPECT_GT(stats().forces, 200U);
  EXPECT_EQ(device.written.back().force_n, Vec3::Zero());
}

TEST_F(NetworkLoops, TighterLimitsHold) {
  make({.tighter_limits = {.max_force_n = 1.5}});
  join(kHaptics, NodeRole::haptics);
  run(300);
  EXPECT_NEAR(device.written.back().force_n.z(), 1.5, 1e-9);
}

// Datagrams overtake each other. A message that comes after a newer one of the same kind and node is out of date.
TEST_F(NetworkLoops, AMessageThatItsSuccessorOvertookChangesNothing) {
  make();
  join(kHaptics, NodeRole::haptics);
  join(kVision, NodeRole::vision);
  join(kTool, NodeRole::tool);
  run(20);
  views.clear();
  const std::int64_t late_ns = 5 * kMs;
  const auto say_both = [&](std::uint16_t port, const Message& older, const Message& newer) {
    say(port, older, late_ns);
    say(port, newer);
  };
  ViewTransform older_view;
  older_view.revision = 1;
  older_view.X_WS[3] = 0.01F;
  ViewTransform newer_view = older_view;
  newer_view.X_WS[3] = 0.02F;
  say_both(kVision, older_view, newer_view);
  say_both(kVision, HandTarget{true, Vec3(0.01, 0, 0)}, HandTarget{true, Vec3(0.02, 0, 0)});
  HapticsSetup older_setup;
  older_setup.method_serial = 1;
  HapticsSetup newer_setup;
  newer_setup.method_serial = 2;
  say_both(kHaptics, older_setup, newer_setup);
  say_both(kHaptics, MaterialState{.serial = 1}, MaterialState{.serial = 2});
  say_both(kHaptics, ObjectPose{.serial = 1}, ObjectPose{.serial = 2});
  say_both(kTool, MoveRequest{.request = 1, .p_m = Vec3::Zero()}, MoveRequest{.request = 2, .p_m = Vec3::Zero()});
  say_both(kHaptics, ObjectMove{.source = 1, .serial = 1}, ObjectMove{.source = 1, .serial = 2, .object = 1});
  run(20);
  for (const ViewTransform& view : views) EXPECT_EQ(view.X_WS[3], 0.02F);
  EXPECT_EQ(device.hand_target, Vec3(0.02, 0, 0));
  ASSERT_FALSE(setups.empty());
  for (const auto& [to, each] : setups) EXPECT_EQ(each.method_serial, 2U);
  ASSERT_FALSE(material_states.empty());
  for (const auto& [to, each] : material_states) EXPECT_EQ(each.serial, 2U);
  ASSERT_FALSE(object_poses.empty());
  for (const auto& [to, each] : object_poses) EXPECT_EQ(each.serial, 2U);
  ASSERT_EQ(move_requests.size(), 1U);
  EXPECT_EQ(move_requests[0].second.request, 2U);
  EXPECT_EQ(object_moves.size(), 2U) << "each moves another object";
}

// Carves that were overtaken are sent on as well: otherwise a vision node would request them again.
TEST_F(NetworkLoops, CarvesGoToVisionNodesAndRequestsForThemToHaptics) {
  make();
  join(kHaptics, NodeRole::haptics);
  join(kVision, NodeRole::vision);
  join(kTool, NodeRole::tool);
  run(20);
  Carves first{.source = 1, .newest = 2, .first = 1, .count = 1};
  first.carves[0].radius_m = 0.01F;
  Carves second = first;
  second.first = 2;
  say(kHaptics, first, 5 * kMs);
  say(kHaptics, second);
  say(kVision, CarveStatus{.source = 1, .complete = 1}, 5 * kMs);
  say(kVision, CarveStatus{.source = 1, .complete = 2});
  say(kTool, CarveStatus{.source = 1});
  say(kVision, CarveUndo{.source = 1, .serial = 2});
  say(kTool, CarveUndo{.source = 1, .serial = 1});
  run(20);
  ASSERT_EQ(carves.size(), 2U);
  for (const auto& [to, each] : carves) EXPECT_EQ(to, at(kVision));
  EXPECT_EQ(carves[0].second.first + carves[1].second.first, 3U);
  ASSERT_EQ(carve_statuses.size(), 1U) << "the newest";
  EXPECT_EQ(carve_statuses[0].first, at(kHaptics));
  EXPECT_EQ(carve_statuses[0].second.complete, 2U);
  ASSERT_EQ(carve_undos.size(), 1U) << "from the vision node alone";
  EXPECT_EQ(carve_undos[0].first, at(kHaptics));
  EXPECT_EQ(carve_undos[0].second.serial, 2U);
}

// Parts of shapes go to the haptics node, and its shapes to vision nodes, also if they were overtaken, because each is another part.
TEST_F(NetworkLoops, PartsOfShapesGoOnInBothDirections) {
  make();
  join(kHaptics, NodeRole::haptics);
  join(kVision, NodeRole::vision);
  join(kTool, NodeRole::tool);
  run(20);
  const ShapeRequest first{.stream = 7, .shape = 1, .part = {.total = 100}};
  ShapeRequest second = first;
  second.part.first = 64;
  say(kTool, first, 5 * kMs);
  say(kTool, second);
  say(kVision, ShapeRequest{.stream = 9, .shape = 1, .part = {.total = 100}});
  say(kHaptics, first);  // a haptics node may not send this
  say(kHaptics, ObjectShape{.source = 3, .serial = 1, .part = {.total = 100}}, 5 * kMs);
  say(kHaptics, ObjectShape{.source = 3, .serial = 1, .part = {.total = 100, .first = 64}});
  say(kHaptics, ShapeStart{.source = 3, .serial = 1, .total = 100});
  say(kTool, ShapeStart{.source = 3, .serial = 2, .total = 100});  // a tool may not send this
  say(kVision, ShapeStatus{.source = 3, .serial = 1});
  say(kTool, ShapeStatus{.source = 3, .serial = 1});  // a tool may not send this
  run(20);
  ASSERT_EQ(shape_requests.size(), 3U);
  for (const auto& [to, part] : shape_requests) EXPECT_EQ(to, at(kHaptics));
  ASSERT_EQ(object_shapes.size(), 2U);
  for (const auto& [to, part] : object_shapes) EXPECT_EQ(to, at(kVision));
  ASSERT_EQ(shape_starts.size(), 1U);
  EXPECT_EQ(shape_starts[0].first, at(kVision));
  ASSERT_EQ(shape_statuses.size(), 1U);
  EXPECT_EQ(shape_statuses[0].first, at(kHaptics));
  say(kHaptics, ShapeReply{.stream = 9, .shape = 1});
  say(kHaptics, ShapeReply{.stream = 7, .shape = 1});
  say(kHaptics, ShapeReply{.stream = 8, .shape = 1});  // nobody has sent this stream
  run(5);
  ASSERT_EQ(shape_replies.size(), 2U);
  EXPECT_EQ(shape_replies[0].first, at(kVision));
  EXPECT_EQ(shape_replies[1].first, at(kTool));
}

// One sender's flood neither crowds out another sender nor slows the haptics node.
TEST_F(NetworkLoops, AFloodOfPartsIsCutOffAndCounted) {
  make();
  join(kHaptics, NodeRole::haptics);
  join(kTool, NodeRole::tool);
  join(kVision, NodeRole::vision);
  run(5);
  std::uint32_t shape = 0;
  for (int cycle = 0; cycle < 1000; ++cycle) {
    for (int n = 0; n < 12; ++n) say(kTool, ShapeRequest{.stream = 7, .shape = ++shape, .part = {.total = 1}});
    if (cycle % 10 == 0) say(kVision, ShapeRequest{.stream = 9, .shape = ++shape, .part = {.total = 1}});
    run(1);
  }
  run(5);
  const auto from_flood =
      std::count_if(shape_requests.begin(), shape_requests.end(), [](const auto& one) { return one.second.stream == 7; });
  EXPECT_LE(from_flood, RequestHandler::kShapePartsPerSecond + RequestHandler::kShapePartsAtOnce + 20);
  EXPECT_GT(from_flood, RequestHandler::kShapePartsPerSecond / 2);
  EXPECT_EQ(shape_requests.size() - static_cast<std::size_t>(from_flood), 100U) << "all of the other sender";
  EXPECT_EQ(stats().shape_parts_rejected, 12'000U - static_cast<std::uint64_t>(from_flood));
}

}  // namespace
}  // namespace hapton
