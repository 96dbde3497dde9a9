// How the sender of the scene's parts uses the position of the hand, the round trip of the hub and what the hub supports.
#include <gtest/gtest.h>

#include <chrono>
#include <string>
#include <utility>

#include "tests/haptics_node/sender_with_hub.h"
#include "tests/support/log_of.h"

namespace hapton {
namespace {

// The scene is much larger than the reach and is moved by 6 m. Away from the hand the hub has nothing.
TEST(PatchSenderHand, WhatIsNearTheHandIsSentAlsoWhereTheSceneWasMoved) {
  SenderWithHub setup(true, scene_of(made::sheet(10.0, 0.0, 150)));
  setup.p_WD = Vec3(8.0, 8.0, 0.0);
  setup.X_WS = {1, 0, 0, 6, 0, 1, 0, 0, 0, 0, 1, 0};
  const Vec3 p_SD(2.0, 8.0, 0.0);
  EXPECT_TRUE(setup.receive_until([&] { return setup.store.has_begun() && setup.store.known_radius(p_SD) > 0.5; }));
  EXPECT_LT(setup.store.known_radius(Vec3(-8.0, -8.0, 0.0)), 0.5);
}

TEST(PatchSenderHand, MovesBeginLaterTheLongerTheRoundTripOfTheHubIs) {
  SenderWithHub setup;
  const std::int64_t now_ns = setup.clock.now_ns();
  EXPECT_EQ(setup.sender.find_lead_ns(now_ns), 0) << "the hub computes no force";
  PatchStatus status;
  status.is_wanted = true;
  // 120 ms and 1.25 round trips, of 2 s at most
  for (const auto& [round_trip_s, lead_ms] : {std::pair(0.0F, 120.0), std::pair(0.2F, 370.0), std::pair(100.0F, 2620.0)}) {
    status.round_trip_s = round_trip_s;
    setup.sender.accept(status, now_ns);
    EXPECT_NEAR(1e-6 * static_cast<double>(setup.sender.find_lead_ns(now_ns)), lead_ms, 1e-3);
  }
  EXPECT_EQ(setup.sender.round_trip_ns(), 2'000'000'000) << "a longer one counts as this";
  EXPECT_EQ(setup.sender.find_lead_ns(now_ns + 1'000'000'000), 0) << "no request for a second";
  status.is_wanted = false;
  setup.sender.accept(status, now_ns);
  EXPECT_EQ(setup.sender.find_lead_ns(now_ns), 0);
}

TEST(PatchSenderHand, ThatTheHubIsTooOldForEffectsIsReportedOnce) {
  TouchScene scene = scene_of(made::sheet(0.05, 0.0, 20));
  scene.effects = {ConstantEffect{.force_n = {0, 0, 1}}};
  SenderWithHub setup(true, scene);
  setup.knows_effects = false;
  const std::string log = log_of([&] {
    EXPECT_TRUE(setup.receive_until([&] { return setup.store.has_begun(); }));
    setup.request += 2;
    setup.receive_for(std::chrono::milliseconds(200));
  });
  const std::size_t first = log.find("io_node is of an earlier version, which cannot compute effects itself");
  ASSERT_NE(first, std::string::npos) << log;
  EXPECT_EQ(log.find("io_node is of an earlier version", first + 1), std::string::npos) << log;
}

}  // namespace
}  // namespace hapton
