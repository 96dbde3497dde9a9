#include "io_node/request_handler.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/io_node/network_loop_fixture.h"

namespace hapton {
namespace {

TEST_F(NetworkLoops, RateChangesWhileRunningAndInvalidOnesAreRejected) {
  make();
  join(kTool, NodeRole::tool);
  run(10);
  for (const double rate : {249.0, 10'001.0, -1.0, 1e300}) say(kTool, Settings{rate, {}, false});
  network->step();
  EXPECT_EQ(network->rate_hz(), 1000.0);
  EXPECT_GE(stats().bad_settings + stats().hub.undecodable, 4U);
  say(kTool, Settings{4000.0, {}, false});
  run(3);
  EXPECT_EQ(network->rate_hz(), 4000.0);
  device.reads.clear();
  run(20);
  for (std::size_t n = 1; n < device.reads.size(); ++n) ASSERT_EQ(device.reads[n] - device.reads[n - 1], 250 * kUs);
  ServoEvent event;
  ASSERT_TRUE(network->events().pop(event));
  EXPECT_EQ(event.kind, ServoEvent::Kind::joined);
  ASSERT_TRUE(network->events().pop(event));
  EXPECT_EQ(event.rate_hz, 4000.0);
}

TEST_F(NetworkLoops, AMethodGoesOnToHapticsAndAReportRequestToTheOtherThread) {
  make();
  join(kHaptics, NodeRole::haptics);
  join(kTool, NodeRole::tool);
  Settings request;
  std::copy_n("sweep", 5, request.method.begin());
  request.report_now = true;
  request.method_request = 77;
  run(5);
  say(kTool, request);
  run(2);
  ASSERT_EQ(settings.size(), 1U);
  EXPECT_STREQ(settings[0].method.data(), "sweep");
  EXPECT_EQ(settings[0].servo_rate_hz, 0.0);
  EXPECT_EQ(settings[0].method_request, 77U);
  EXPECT_FALSE(settings[0].report_now);
  EXPECT_TRUE(network->take_report_request());
  EXPECT_FALSE(network->take_report_request());
  network->request_snapshot();
  EXPECT_FALSE(network->take_snapshot());
  network->step();
  ASSERT_TRUE(network->take_snapshot());
  EXPECT_EQ(network->snapshot().samples, 8U);
}

TEST_F(NetworkLoops, AChangeOfMaterialGoesOnToHapticsAndItsResultToToolsAndVision) {
  make();
  join(kHaptics, NodeRole::haptics);
  join(kTool, NodeRole::tool);
  join(kVision, NodeRole::vision);
  run(5);
  const MaterialRequest request{.request = 7, .object = {"hull"}, .change = {.fields = MaterialChange::kDamping, .damping_ns_per_m = 2.0}};
  say(kTool, request);
  say(kVision, request);  // a vision node may not send this
  run(2);
  ASSERT_EQ(material_requests.size(), 1U);
  EXPECT_EQ(material_requests[0].first, at(kHaptics));
  EXPECT_STREQ(material_requests[0].second.object.data(), "hull");
  EXPECT_EQ(material_requests[0].second.change.damping_ns_per_m, 2.0);
  say(kHaptics, MaterialState{.serial = 1, .request = 7});
  say(kTool, MaterialState{.serial = 1, .request = 8});
  run(2);
  ASSERT_EQ(material_states.size(), 2U);
  EXPECT_EQ(material_states[0].first, at(kTool));
  EXPECT_EQ(material_states[1].first, at(kVision)) << "programs that compute with materials, as `hapton dynamics`";
  for (const auto& [to, each] : material_states) EXPECT_EQ(each.request, 7U);
}

TEST_F(NetworkLoops, PosesOfObjectsGoToToolsAndVisionAndRequestsForOneToHaptics) {
  make();
  join(kHaptics, NodeRole::haptics);
  join(kVision, NodeRole::vision);
  join(kTool, NodeRole::tool);
  run(5);
  say(kHaptics, ObjectPose{.serial = 2, .object = 1, .is_held = true});
  run(2);
  ASSERT_EQ(object_poses.size(), 2U);
  EXPECT_EQ(object_poses[0].first, at(kVision));
  EXPECT_EQ(object_poses[1].first, at(kTool));
  EXPECT_EQ(object_poses[1].second.object, 1);
  say(kTool, ObjectPose{.serial = 4});  // a tool may not send this
  say(kVision, ObjectPose{.serial = 3, .object = 1});
  run(2);
  ASSERT_EQ(object_poses.size(), 3U);
  EXPECT_EQ(object_poses[2].first, at(kHaptics));
  EXPECT_EQ(object_poses[2].second.serial, 3U);
}

MoveRequest request_to_move(std::uint32_t request) { return {.request = request, .object = {"lid"}, .p_m = Vec3(0.1, 0, 0)}; }

TEST_F(NetworkLoops, ARequestToMoveGoesOnToHapticsAndItsReplyToWhoSentIt) {
  make();
  join(kHaptics, NodeRole::haptics);
  join(kTool, NodeRole::tool);
  join(kVision, NodeRole::vision);
  run(5);
  say(kTool, request_to_move(7));
  run(1);
  say(kVision, request_to_move(8));
  run(1);
  ASSERT_EQ(move_requests.size(), 2U);
  for (const auto& [to, request] : move_requests) EXPECT_EQ(to, at(kHaptics));
  EXPECT_EQ(move_requests[0].second.request, 7U);
  say(kHaptics, MoveReply{.request = 8});
  run(1);
  say(kHaptics, MoveReply{.request = 7});
  run(1);
  say(kHaptics, MoveReply{.request = 9});  // nobody has sent this request
  say(kTool, MoveReply{.request = 7});     // a tool may not send this
  say(kHaptics, ObjectMove{.source = 3, .serial = 1, .object = 2});
  run(2);
  ASSERT_EQ(move_replies.size(), 2U);
  EXPECT_EQ(move_replies[0].first, at(kVision));
  EXPECT_EQ(move_replies[1].first, at(kTool));
  ASSERT_EQ(object_moves.size(), 1U);
  EXPECT_EQ(object_moves[0].first, at(kVision)) << "who draws it";
  EXPECT_EQ(object_moves[0].second.object, 2);
}

// One sender's flood neither crowds out another sender nor reaches the haptics node.
TEST_F(NetworkLoops, AFloodOfRequestsToMoveIsCutOffAndCounted) {
  make();
  join(kHaptics, NodeRole::haptics);
  join(kTool, NodeRole::tool);
  join(kVision, NodeRole::vision);
  run(5);
  std::uint32_t request = 1000;
  for (int cycle = 0; cycle < 1000; ++cycle) {
    for (int n = 0; n < 4; ++n) say(kTool, request_to_move(++request));
    if (cycle % 100 == 0) say(kVision, request_to_move(1 + static_cast<std::uint32_t>(cycle)));
    run(1);
  }
  run(5);
  const auto from_flood =
      std::count_if(move_requests.begin(), move_requests.end(), [](const auto& one) { return one.second.request > 1000; });
  EXPECT_LE(from_flood, RequestHandler::kMovesPerSecond + RequestHandler::kMovesAtOnce + 2);
  EXPECT_GT(from_flood, RequestHandler::kMovesPerSecond / 2);
  EXPECT_EQ(move_requests.size() - static_cast<std::size_t>(from_flood), 10U) << "all of the other sender";
  EXPECT_EQ(stats().moves_rejected, 4000U - static_cast<std::uint64_t>(from_flood));
}

TEST_F(NetworkLoops, AReplyDoesNotGoToANodeThatTookTheSendersSlot) {
  make();
  join(kHaptics, NodeRole::haptics);
  join(kTool, NodeRole::tool);
  run(5);
  say(kTool, request_to_move(7));
  run(1);
  say(kTool, Bye{});
  run(1);
  join(kVision, NodeRole::vision);
  run(2);
  say(kHaptics, MoveReply{.request = 7});
  run(2);
  EXPECT_TRUE(move_replies.empty());
}

TEST_F(NetworkLoops, WhoLeadsTheHandHoldsItsButtons) {
  make();
  join(kVision, NodeRole::vision);
  run(5);
  say(kVision, HandTarget{true, Vec3(0.01, 0, 0), 1});
  run(2);
  EXPECT_EQ(device.hand_buttons, 1U);
  say(kVision, HandTarget{false, Vec3::Zero(), 1});
  run(2);
  EXPECT_EQ(device.hand_buttons, 0U) << "released";
}

TEST_F(NetworkLoops, TheHapticsSetupGoesToToolsAndVision) {
  make();
  join(kHaptics, NodeRole::haptics);
  join(kVision, NodeRole::vision);
  join(kTool, NodeRole::tool);
  run(5);
  HapticsSetup rejected{.method_request = 77};
  std::copy_n("no", 2, rejected.rejection.begin());
  say(kHaptics, rejected);
  say(kTool, HapticsSetup{.method_request = 78});
  run(2);
  ASSERT_EQ(setups.size(), 2U);
  EXPECT_EQ(setups[0].first, at(kTool));
  EXPECT_EQ(setups[1].first, at(kVision)) << "it draws the probe at its true size";
  for (const auto& [to, setup] : setups) {
    EXPECT_EQ(setup.method_request, 77U);
    EXPECT_STREQ(setup.rejection.data(), "no");
  }
}

TEST_F(NetworkLoops, TheMouseLeadsTheHandUntilItReleasesOrLeaves) {
  make();
  join(kVision, NodeRole::vision);
  run(2);
  const HandTarget target{true, Vec3(0.01, 0, 0), 0, Vec3(9.0, -0.5, 0.25)};
  say(kVision, target);
  run(2);
  ASSERT_TRUE(device.hand_target);
  EXPECT_EQ(*device.hand_target, Vec3(0.01, 0, 0));
  EXPECT_EQ(device.turn_rad, target.turn_rad);
  say(kVision, HandTarget{});
  run(2);
  EXPECT_FALSE(device.hand_target);
  EXPECT_EQ(device.turn_rad, Vec3::Zero());
  say(kVision, target);
  run(2);
  ASSERT_TRUE(device.hand_target);
  say(kVision, Bye{});
  run(2);
  EXPECT_FALSE(device.hand_target);
  EXPECT_EQ(device.turn_rad, Vec3::Zero());
}

TEST_F(NetworkLoops, AnotherVisionNodeDoesNotReleaseTheHand) {
  make();
  join(kVision, NodeRole::vision);
  constexpr std::uint16_t kOtherVision = 9;
  say(kOtherVision, Hello{NodeRole::vision});
  run(3);
  ASSERT_EQ(peers.count(NodeRole::vision), 2U);
  say(kVision, HandTarget{true, Vec3(0.01, 0, 0)});
  run(3);
  ASSERT_TRUE(device.hand_target);
  say(kOtherVision, HandTarget{});
  run(3);
  EXPECT_TRUE(device.hand_target);
  say(kOtherVision, Bye{});
  run(3);
  EXPECT_EQ(peers.count(NodeRole::vision), 1U);
  EXPECT_TRUE(device.hand_target);
}

TEST_F(NetworkLoops, ALatchedFaultIsReportedRecordedAndResetByAToolAlone) {
  RecordingTap tap;
  make({.dead_mans_switch = 3}, nullptr, &tap);  // the switch is held: someone is at the device
  join(kHaptics, NodeRole::haptics);
  join(kVision, NodeRole::vision);
  join(kTool, NodeRole::tool);
  run(300);
  device.place.x() += 0.05;
  run(20);
  EXPECT_EQ(device.written.back().force_n, Vec3::Zero());
  EXPECT_EQ(tap.faults, std::vector{SessionFault::jump});
  const auto latched = events_of(*network, {ServoEvent::Kind::latched});
  ASSERT_EQ(latched.size(), 1U);
  EXPECT_EQ(latched[0].fault, SafetyFault::jump);
  EXPECT_EQ(stats().governor.fault, SafetyFault::jump);
  EXPECT_EQ(stats().governor.state, GovernorState::latched);
  Settings reset;
  reset.reset_faults = true;
  say(kVision, reset);
  run(300);
  EXPECT_EQ(device.written.back().force_n, Vec3::Zero());
  EXPECT_TRUE(events_of(*network, {ServoEvent::Kind::reset}).empty());
  say(kTool, reset);
  run(20);
  EXPECT_EQ(events_of(*network, {ServoEvent::Kind::reset}).size(), 1U);
  EXPECT_LT(device.written.back().force_n.z(), 0.6);
  run(150);
  EXPECT_EQ(device.written.back().force_n, force_reply.force_n);
  EXPECT_EQ(tap.faults, std::vector{SessionFault::jump});
  peers.set_tap(nullptr);
}

TEST_F(NetworkLoops, AResetIsRejectedWhileTheCauseIsThere) {
  make({.dead_mans_switch = 3});
  join(kHaptics, NodeRole::haptics);
  join(kTool, NodeRole::tool);
  run(300);
  device.condition_now.motor_temperature = 1.0;
  run(600);
  EXPECT_EQ(stats().governor.fault, SafetyFault::thermal);
  EXPECT_EQ(device.written.back().force_n, Vec3::Zero());
  Settings reset;
  reset.reset_faults = true;
  say(kTool, reset);
  run(10);
  EXPECT_EQ(events_of(*network, {ServoEvent::Kind::reset_rejected}).size(), 1U);
  device.condition_now.motor_temperature = 0.5;
  run(600);
  say(kTool, reset);
  run(300);
  EXPECT_EQ(device.written.back().force_n, force_reply.force_n);
}

TEST_F(NetworkLoops, AResetTakesAnOperatorsKeyAndAPersonAtTheDevice) {
  KeyRole tools_key = KeyRole::tool;
  endpoint.key_role_of = [&](const Address& from) {
    return from.port == kTool ? tools_key : from.port == kVision ? KeyRole::vision : KeyRole::haptics;
  };
  Settings reset;
  reset.reset_faults = true;
  const auto reset_by = [&](KeyRole key_role, int dead_mans_switch) {
    tools_key = key_role;
    make({.dead_mans_switch = dead_mans_switch});
    join(kHaptics, NodeRole::haptics);
    join(kTool, NodeRole::tool);
    run(300);
    device.place.x() = -device.place.x() + 0.05;
    run(20);
    EXPECT_NE(stats().governor.fault, SafetyFault::none);
    events_of(*network, {});
    say(kTool, reset);
    run(20);
    const auto reported =
        events_of(*network, {ServoEvent::Kind::reset, ServoEvent::Kind::reset_without_right, ServoEvent::Kind::reset_without_person});
    EXPECT_EQ(reported.size(), 1U);
    const bool is_reset = !reported.empty() && reported[0].kind == ServoEvent::Kind::reset;
    EXPECT_EQ(stats().governor.fault == SafetyFault::none, is_reset);
    EXPECT_EQ(stats().resets_denied, is_reset ? 0U : 1U);
    say(kTool, Bye{});
    run(2);
    return reported.empty() ? ServoEvent::Kind::joined : reported[0].kind;
  };
  // From another host, with no dead man's switch, or with one that is held.
  EXPECT_EQ(reset_by(KeyRole::tool, 0), ServoEvent::Kind::reset_without_right);
  EXPECT_EQ(reset_by(KeyRole::tool, 3), ServoEvent::Kind::reset_without_right);
  EXPECT_EQ(reset_by(KeyRole::operator_role, 0), ServoEvent::Kind::reset_without_person);
  EXPECT_EQ(reset_by(KeyRole::operator_role, 3), ServoEvent::Kind::reset);
}

TEST_F(NetworkLoops, DeniedResetsAreAllCountedAndReportedOnceASecond) {
  endpoint.key_role_of = [](const Address& from) { return from.port == kTool ? KeyRole::tool : KeyRole::haptics; };
  make();
  join(kHaptics, NodeRole::haptics);
  join(kTool, NodeRole::tool);
  run(300);
  device.place.x() = -device.place.x() + 0.05;
  run(20);
  Settings reset;
  reset.reset_faults = true;
  std::size_t reported = 0;
  for (int n = 0; n < 1500; ++n) {
    say(kTool, reset);
    run(1);
    reported += events_of(*network, {ServoEvent::Kind::reset_without_right}).size();
  }
  EXPECT_GE(stats().resets_denied, 1499U);
  EXPECT_EQ(reported, 2U);
}

}  // namespace
}  // namespace hapton
