#include "io_node/scene_relay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "tests/io_node/network_loop_fixture.h"

namespace hapton {
namespace {

TEST_F(NetworkLoops, HapticsAndVisionGetEachOthersScene) {
  make();
  join(kHaptics, NodeRole::haptics);
  join(kVision, NodeRole::vision);
  join(kTool, NodeRole::tool);
  run(5);
  say(kHaptics, SceneFacts{.given_hash = 1});
  run(2);
  say(kVision, SceneFacts{.given_hash = 2});
  run(2);
  say(kTool, SceneFacts{.given_hash = 3});
  run(2);
  ASSERT_EQ(scenes.size(), 2U);
  EXPECT_EQ(scenes[0].first, at(kVision));
  EXPECT_EQ(scenes[0].second.given_hash, 1U);
  EXPECT_EQ(scenes[1].first, at(kHaptics));
  EXPECT_EQ(scenes[1].second.given_hash, 2U);
}

TEST_F(NetworkLoops, TheHandGetsThePoseOfTheSceneAndItsChanges) {
  make();
  join(kHaptics, NodeRole::haptics);
  join(kVision, NodeRole::vision);
  run(5);
  say(kHaptics,
      SceneFacts{.given_hash = 1, .lowest_m = {0, 0, 0}, .highest_m = {0.08F, 0, 0}, .point_count = 1, .points_m = {{{0.08F, 0, 0}}}});
  run(3);
  ASSERT_EQ(device.aims.size(), 1U);
  EXPECT_LT((device.aims[0] - Vec3(0.08, 0, 0)).norm(), 1e-6);
  EXPECT_EQ(network->collect_stats().reach, SceneReach::in_reach);
  say(kVision, ViewTransform{.revision = 1, .X_WS = {0, -1, 0, 0, 1, 0, 0, 0.5F, 0, 0, 1, 0}});
  run(3);
  EXPECT_LT((device.aims[0] - Vec3(0, 0.58, 0)).norm(), 1e-6);
  EXPECT_EQ(network->collect_stats().reach, SceneReach::out_of_reach);
  ASSERT_FALSE(probes.empty());
  EXPECT_EQ(probes.back().status, ProbeStatus::out_of_reach);
}

TEST_F(NetworkLoops, WhetherTheSceneCanBeTouchedIsReportedWhenItChanges) {
  make();
  join(kHaptics, NodeRole::haptics);
  run(5);
  const auto describe_box = [&](float x, float half) {
    SceneFacts facts{.given_hash = 1, .lowest_m = {x - half, -half, -half}, .highest_m = {x + half, half, half}, .point_count = 1};
    facts.points_m[0] = {x + half, 0, 0};
    say(kHaptics, facts);
    run(3);
  };
  describe_box(0.0F, 0.05F);
  for (const auto& [x, half] : {std::pair(0.3F, 0.05F), std::pair(0.0F, 0.04F), std::pair(0.0F, 1e-4F), std::pair(0.0F, 0.06F)}) {
    describe_box(x, half);
  }
  std::vector<ServoEvent::Kind> kinds;
  using Kind = ServoEvent::Kind;
  for (const ServoEvent& event : events_of(*network, {Kind::out_of_reach, Kind::too_small, Kind::in_reach})) kinds.push_back(event.kind);
  EXPECT_EQ(kinds, (std::vector{Kind::out_of_reach, Kind::in_reach, Kind::too_small, Kind::in_reach}));
}

TEST_F(NetworkLoops, VisionIsNotifiedWhyThereIsNoForce) {
  make();
  join(kVision, NodeRole::vision);
  run(200);
  ASSERT_FALSE(probes.empty());
  EXPECT_EQ(probes.back().status, ProbeStatus::no_haptics);
  join(kHaptics, NodeRole::haptics);
  run(500);
  EXPECT_EQ(probes.back().status, ProbeStatus::ok);
  SceneFacts facts{.given_hash = 1, .lowest_m = {-0.02F, -0.02F, -0.02F}, .highest_m = {0.02F, 0.02F, 0.02F}, .is_hand_inside = true};
  say(kHaptics, facts);
  run(200);
  EXPECT_EQ(probes.back().status, ProbeStatus::hand_inside);
  facts.is_hand_inside = false;
  say(kHaptics, facts);
  run(200);
  EXPECT_EQ(probes.back().status, ProbeStatus::ok);
  device.device_status = DeviceStatus::calibrating;
  run(200);
  EXPECT_EQ(probes.back().status, ProbeStatus::calibrating);
  device.device_status = DeviceStatus::away;
  run(200);
  EXPECT_EQ(probes.back().status, ProbeStatus::device_away);
  device.device_status = DeviceStatus::ready;
  run(1000);
  EXPECT_EQ(probes.back().status, ProbeStatus::ok);
  reply_delay_ns = -1;
  run(200);
  EXPECT_EQ(probes.back().status, ProbeStatus::no_haptics);
  reply_delay_ns = 100 * kUs;
  run(500);
  network->device_loop().restore_latched_fault(SafetyFault::speed);
  run(200);
  EXPECT_EQ(probes.back().status, ProbeStatus::fault_latched);
}

TEST_F(NetworkLoops, KeepsTheSceneAndSetupOfTheHapticsNode) {
  make();
  join(kHaptics, NodeRole::haptics);
  run(5);
  HapticsSetup setup{.scene_hash = 0xABCD};
  std::copy_n("car.toml", 8, setup.scene.begin());
  say(kHaptics, setup);
  run(2);
  EXPECT_EQ(network->collect_stats().setup.scene_hash, 0xABCDU);
  EXPECT_STREQ(network->collect_stats().setup.scene.data(), "car.toml");
  EXPECT_EQ(network->collect_stats().scene_given_hash, 0U);
  say(kHaptics, SceneFacts{.given_hash = 0xFACADE});
  run(2);
  EXPECT_EQ(network->collect_stats().scene_given_hash, 0xFACADEU);
}

}  // namespace
}  // namespace hapton
