// Messages about carves, in the loop of the haptics node: in simulated time, with a hub.
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <vector>

#include "haptics_node/reply_loop.h"
#include "link/known_carves.h"
#include "scene/object_reader.h"
#include "tests/haptics_node/reply_loop_stage.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

constexpr std::uint32_t kCarveSource = 42;

Scene clay_scene() {
  Scene scene;
  SceneObject object;
  object.name = "clay";
  object.mesh = made::shared(made::box(Vec3(-0.05, -0.05, -0.02), Vec3(0.05, 0.05, 0.0)));
  scene.objects.push_back(object);
  return scene;
}

class ReplyLoopCarves : public ReplyLoopStage {
 protected:
  ReplyLoopCarves() {
    loop_.set_carve_sender(&carves_);
    for (int i = 0; i < 10 && client_.state() != JoinState::joined; ++i) cycle();
    cycle();
  }

  // Sends a sample, runs the loop once, and receives at the hub for a millisecond.
  void cycle() {
    send(DeviceState{.sample = ++sample_, .sample_time_ns = clock_.now_ns(), .p_WD = Vec3(0.0, 0.0, 0.1)});
    loop_.turn(clock_.now_ns() + kMs);
    order_.clear();
    receive_at_hub();
  }
  void take(const Message& message) override {
    if (const auto* got = std::get_if<ForceCommand>(&message)) {
      echoed_ = got->echo_sample;
      if (!received_before_force_) received_before_force_ = received_.size();
    }
    if (const auto* got = std::get_if<Carves>(&message)) {
      received_.push_back(*got);
      viewer_.take(*got, Arrival::newest);
    }
  }
  void carve(std::uint32_t count) {
    for (std::uint32_t n = 0; n < count; ++n)
      carves_.note({.object = 0, .serial = carves_.newest() + 1, .carve = {Vec3::Zero(), Vec3::Zero(), 0.01}});
  }

  Scene scene_ = clay_scene();
  HapticsStep step_{std::make_unique<TouchStep>(*make_method({}, scene_.touch_scene()), scene_.touch_scene()), 1e-5};
  MethodBuilder builder_{{}, scene_.touch_scene()};
  CarveSender carves_{kCarveSource, 10'000};
  ReplyLoop loop_{client_, clock_, step_, builder_, {.scene_hash = 42}};
  std::vector<Carves> received_;
  KnownCarves viewer_;
  std::optional<std::size_t> received_before_force_;  // how many came before the first force
  std::uint64_t echoed_ = 0;
  std::uint64_t sample_ = 0;
};

// A picture may still show what another process carved.
TEST_F(ReplyLoopCarves, TheProcessIsAnnouncedBeforeTheFirstForce) {
  ASSERT_EQ(client_.state(), JoinState::joined);
  EXPECT_EQ(received_before_force_, 1U);
  ASSERT_FALSE(received_.empty());
  EXPECT_EQ(received_[0].source, kCarveSource);
  EXPECT_EQ(received_[0].newest, 0U);
  EXPECT_EQ(received_[0].count, 0U);
}

TEST_F(ReplyLoopCarves, ACarveIsSentAtOnceAndItsSerialOnceASecond) {
  for (int n = 0; n < 500; ++n) cycle();
  received_.clear();
  carve(1);
  cycle();
  ASSERT_EQ(received_.size(), 1U);
  EXPECT_EQ(received_[0].count, 1U);
  for (int n = 0; n < 500; ++n) cycle();
  received_.clear();
  for (int n = 0; n < 3000; ++n) cycle();  // 1 ms each
  EXPECT_GE(received_.size(), 2U);
  EXPECT_LE(received_.size(), 4U);
  for (const Carves& each : received_) {
    EXPECT_EQ(each.newest, 1U);
    EXPECT_EQ(each.count, 0U);
  }
}

TEST_F(ReplyLoopCarves, WhatIsMissingIsSentAgain) {
  carve(2000);
  for (int n = 0; n < 500; ++n) cycle();
  viewer_ = {};
  for (int n = 0; n < 2000 && (viewer_.newest() == 0 || viewer_.complete() < 2000); ++n) {
    if (const auto request = viewer_.take_request(clock_.now_ns())) send(*request);
    cycle();
  }
  EXPECT_EQ(viewer_.complete(), 2000U);
}

// However much is requested, each sample gets its reply before anything else is sent.
TEST_F(ReplyLoopCarves, AFloodOfRequestsNeverComesBeforeAForce) {
  carve(5000);
  for (int n = 0; n < 1000; ++n) cycle();
  received_.clear();
  for (int n = 0; n < 400; ++n) {
    for (int k = 0; k < 20; ++k) send(CarveStatus{.source = kCarveSource, .complete = static_cast<std::uint32_t>(k % 7)});
    cycle();
    ASSERT_EQ(echoed_, sample_);
    ASSERT_FALSE(order_.empty());
    ASSERT_EQ(order_[0], Message(ForceCommand()).index()) << n;
  }
  EXPECT_LE(received_.size(), 400U / 5U + 4U) << "one in 5 ms, of 1 ms a cycle";
  EXPECT_GE(received_.size(), 400U / 5U);
}

TEST_F(ReplyLoopCarves, WithoutAnythingToCarveNothingIsSent) {
  loop_.set_carve_sender(nullptr);
  received_.clear();
  send(CarveStatus{.source = kCarveSource});
  for (int n = 0; n < 1500; ++n) cycle();
  EXPECT_TRUE(received_.empty());
}

}  // namespace
}  // namespace hapton
