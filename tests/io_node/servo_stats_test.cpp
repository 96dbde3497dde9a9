#include "io_node/servo_stats.h"

#include <gtest/gtest.h>

#include <cstddef>

#include "tests/io_node/network_loop_fixture.h"

namespace hapton {
namespace {

TEST_F(NetworkLoops, EverySlotOfTheHubIsInTheStatistics) {
  make();
  join(kHaptics, NodeRole::haptics);
  join(kVision, NodeRole::vision);
  join(kTool, NodeRole::tool);
  run(20);
  const ServoStats& report = stats();
  std::size_t present = 0;
  for (std::size_t slot = 0; slot < HubPeers::kCapacity; ++slot) {
    const Peer& peer = peers.peer(slot);
    const PeerStats& reported = report.peers[slot];
    present += reported.present ? 1U : 0U;
    EXPECT_EQ(reported.present, peer.present) << slot;
    EXPECT_EQ(reported.role, peer.role) << slot;
    EXPECT_EQ(reported.address, peer.address) << slot;
    EXPECT_EQ(reported.joined_ns, peer.joined_ns) << slot;
    EXPECT_EQ(reported.sent, peer.sent) << slot;
    EXPECT_EQ(reported.send_failures, peer.send_failures) << slot;
    EXPECT_EQ(reported.sequence.received, peer.tracker.counts().received) << slot;
  }
  EXPECT_EQ(present, 3U);
  EXPECT_EQ(report.peers[HubPeers::kHapticsSlot].role, NodeRole::haptics);
  EXPECT_EQ(report.peers[HubPeers::kHapticsSlot].address, at(kHaptics));
  EXPECT_GE(report.peers[HubPeers::kHapticsSlot].sent, 20U);
  EXPECT_GE(report.peers[HubPeers::kHapticsSlot].sequence.received, 20U);
  EXPECT_EQ(report.hub.received, peers.counts().received);
  EXPECT_GE(report.hub.received, 23U);
}

TEST(ServoStats, WhatTheDeviceSideMeasuredIsTakenOverAsItIs) {
  DeviceLoopStats device;
  device.start_ns = 1;
  device.end_ns = 2;
  device.rate_hz = 3.0;
  device.wake_lateness.record(4);
  for (int n = 0; n < 5; ++n) device.device_read.record(5);
  device.samples = 6;
  device.missed_cycles = 7;
  device.caught_up_cycles = 8;
  device.missed_by_cause = {9, 10, 11, 12, 13};
  device.max_force_n = 14.0;
  device.max_torque_nm = 15.0;
  device.longest_release_ns = 16;
  device.governor.counters.clamped = 17;
  device.status = DeviceStatus::away;
  device.condition.motor_temperature = 18.0;
  device.resets_denied = 19;
  device.cuts = 20;
  device.local_forces = 21;
  device.cycles_unreported = 22;
  ServoStats stats;
  add_device_stats(device, stats);
  EXPECT_EQ(stats.start_ns, 1);
  EXPECT_EQ(stats.end_ns, 2);
  EXPECT_EQ(stats.rate_hz, 3.0);
  EXPECT_EQ(stats.wake_lateness.count(), 1U);
  EXPECT_EQ(stats.device_read.count(), 5U);
  EXPECT_EQ(stats.samples, 6U);
  EXPECT_EQ(stats.missed_cycles, 7U);
  EXPECT_EQ(stats.caught_up_cycles, 8U);
  EXPECT_EQ(stats.missed_by_cause, device.missed_by_cause);
  EXPECT_EQ(stats.max_force_n, 14.0);
  EXPECT_EQ(stats.max_torque_nm, 15.0);
  EXPECT_EQ(stats.longest_release_ns, 16);
  EXPECT_EQ(stats.governor.counters.clamped, 17U);
  EXPECT_EQ(stats.device_status, DeviceStatus::away);
  EXPECT_EQ(stats.device.motor_temperature, 18.0);
  EXPECT_EQ(stats.resets_denied, 19U);
  EXPECT_EQ(stats.cuts, 20U);
  EXPECT_EQ(stats.local_forces, 21U);
  EXPECT_EQ(stats.cycles_unreported, 22U);
  EXPECT_NEAR(stats.seconds(), 1e-9, 1e-18);
}

}  // namespace
}  // namespace hapton
