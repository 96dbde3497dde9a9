#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/io_node/network_loop_fixture.h"

namespace hapton {
namespace {

TEST_F(NetworkLoops, UnknownPeersAreReportedAtALimitedRate) {
  make();
  run(1000);
  ServoEvent event;
  EXPECT_FALSE(network->events().pop(event));
  int reports_of_key = 0;
  int reports_of_version = 0;
  for (int second = 0; second < 30; ++second) {
    endpoint.seal.wrong_key += 20;
    endpoint.seal.wrong_version += second == 0 ? 1 : 0;
    run(1000);
    while (network->events().pop(event)) {
      reports_of_key += event.kind == ServoEvent::Kind::wrong_key ? 1 : 0;
      reports_of_version += event.kind == ServoEvent::Kind::wrong_version ? 1 : 0;
    }
  }
  EXPECT_EQ(reports_of_key, 3);
  EXPECT_EQ(reports_of_version, 1);
}

TEST_F(NetworkLoops, ATapReceivesDatagramsAndCycles) {
  RecordingTap tap;
  make({}, nullptr, &tap);
  join(kHaptics, NodeRole::haptics);
  run(200);
  ASSERT_EQ(tap.cycles.size(), 200U);
  EXPECT_EQ(tap.cycles.back().sample, states.back().sample);
  EXPECT_EQ(tap.cycles.back().written_n, force_reply.force_n);
  ASSERT_TRUE(tap.cycles.back().device);
  EXPECT_EQ(tap.cycles.back().device->p_WD, states.back().p_WD);
  EXPECT_EQ(tap.cycles.back().device->time_ns, states.back().sample_time_ns);
  EXPECT_FALSE(tap.cycles.back().local);
  EXPECT_EQ(static_cast<std::uint64_t>(tap.received), stats().hub.received);
  EXPECT_GE(tap.sent, 200);
  EXPECT_TRUE(tap.faults.empty());
  clock.advance_ns(3 * kMs);
  run(1);
  EXPECT_EQ(tap.cycles.back().missed, 2U);
  peers.set_tap(nullptr);
}

TEST_F(NetworkLoops, ATapReceivesEachFaultOnce) {
  RecordingTap tap;
  make({}, nullptr, &tap);
  join(kHaptics, NodeRole::haptics);
  run(200);
  reply_delay_ns = -1;
  run(40);
  EXPECT_EQ(tap.faults, std::vector{SessionFault::command_timeout});
  reply_delay_ns = 100 * kUs;
  run(10);
  tap.faults.clear();
  force_reply.force_n = Vec3(0, 0, 100);
  run(10);
  EXPECT_EQ(tap.faults, std::vector{SessionFault::clamped});
  force_reply.force_n = Vec3(0, 0, 1);
  run(5);
  tap.faults.clear();
  clock.advance_ns(25 * kMs);
  run(1);
  EXPECT_EQ(tap.faults.back(), SessionFault::stalled);
  tap.faults.clear();
  device.device_status = DeviceStatus::fault;
  network->finish();
  EXPECT_EQ(tap.faults, std::vector{SessionFault::device});
  peers.set_tap(nullptr);
}

TEST_F(NetworkLoops, ADeviceThatFailsIsRecordedOnceThoughThatEndsTheSession) {
  RecordingTap tap;
  make({}, nullptr, &tap);
  run(10);
  device.device_status = DeviceStatus::fault;
  run(10);
  EXPECT_EQ(tap.faults, std::vector{SessionFault::device});
  network->finish();
  EXPECT_EQ(tap.faults, std::vector{SessionFault::device});
  peers.set_tap(nullptr);
}

// The fault is latched while the force is released at the end. Whoever keeps it for the next start must learn of it.
TEST_F(NetworkLoops, AFaultThatIsLatchedAtTheEndIsReportedAndRecorded) {
  RecordingTap tap;
  make({}, nullptr, &tap);
  run(240);
  device.condition_now.motor_temperature = 1.0;  // the temperature is read every 250 ms
  network->finish();
  EXPECT_EQ(tap.faults, std::vector{SessionFault::thermal});
  const auto latched = events_of(*network, {ServoEvent::Kind::latched});
  ASSERT_EQ(latched.size(), 1U);
  EXPECT_EQ(latched[0].fault, SafetyFault::thermal);
  peers.set_tap(nullptr);
}

TEST_F(NetworkLoops, AKeyThatDoesNotAllowARoleIsReported) {
  endpoint.key_role_of = [](const Address& from) { return from.port == kTool ? KeyRole::vision : KeyRole::haptics; };
  make();
  join(kHaptics, NodeRole::haptics);
  run(300);
  EXPECT_TRUE(events_of(*network, {ServoEvent::Kind::role_violation}).empty());
  for (int n = 0; n < 500; ++n) {
    say(kTool, Hello{.role = NodeRole::haptics});
    run(1);
  }
  run(300);
  EXPECT_EQ(events_of(*network, {ServoEvent::Kind::role_violation}).size(), 1U);
  EXPECT_GE(stats().hub.role_violations, 499U);
}

TEST_F(NetworkLoops, ASecondHapticsNodeThatKeepsTryingIsReportedOnce) {
  make();
  join(kHaptics, NodeRole::haptics);
  run(10);
  for (int n = 0; n < 20; ++n) {
    join(9, NodeRole::haptics);
    say(kHaptics, Hello{NodeRole::haptics});
    run(20);
  }
  const auto rejected = events_of(*network, {ServoEvent::Kind::rejected});
  ASSERT_EQ(rejected.size(), 1U);
  EXPECT_EQ(rejected[0].role, NodeRole::haptics);
  EXPECT_EQ(stats().hub.rejections, 20U);
}

TEST_F(NetworkLoops, AFloodIsReportedWithItsSource) {
  make();
  run(100);
  endpoint.flood = Flood{Rejection::replayed_handshake, at(66), true, 200'000.0};
  run(300);
  const auto reported = events_of(*network, {ServoEvent::Kind::flood});
  ASSERT_EQ(reported.size(), 1U);
  EXPECT_EQ(reported[0].flood, Rejection::replayed_handshake);
  EXPECT_EQ(reported[0].address, at(66));
  EXPECT_TRUE(reported[0].is_from_several);
  EXPECT_EQ(reported[0].rate_hz, 200'000.0);
}

TEST_F(NetworkLoops, AHapticsNodeThatSaysGoodbyeInContactIsNoFault) {
  RecordingTap tap;
  make({}, nullptr, &tap);
  join(kHaptics, NodeRole::haptics);
  run(200);
  say(kHaptics, Bye{});
  for (int n = 0; n < 40; ++n) network->step();
  EXPECT_EQ(stats().governor.counters.command_timeouts, 1U);
  EXPECT_TRUE(tap.faults.empty());
  peers.set_tap(nullptr);
}

TEST_F(NetworkLoops, ACommandTimeoutInFreeSpaceIsNoFault) {
  RecordingTap tap;
  make({}, nullptr, &tap);
  join(kHaptics, NodeRole::haptics);
  force_reply.contact = false;
  force_reply.force_n = Vec3::Zero();
  run(200);
  reply_delay_ns = -1;
  run(40);
  EXPECT_EQ(stats().governor.counters.command_timeouts, 1U);
  EXPECT_TRUE(tap.faults.empty());
  peers.set_tap(nullptr);
}

}  // namespace
}  // namespace hapton
