#include "haptics_node/patch_sender.h"

#include <gtest/gtest.h>

#include <chrono>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "patch/patch_store.h"
#include "runtime/clock.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/made_scene.h"

namespace hapton {
namespace {

constexpr std::array<float, 12> kAtW = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

// A sender, and a hub that wants the scene.
struct SenderStage {
  explicit SenderStage(bool is_offered = true, TouchScene scene = scene_of(made::sheet(0.05, 0.0, 20)))
      : sender(std::move(scene), 0.0, 7, is_offered, {.bits_per_s = 1e8, .least_reach_m = 1.0}) {}

  void want() {
    PatchStatus status = store.status();
    status.is_wanted = true;
    sender.accept(status, clock.now_ns());
    sender.note_hand({.sample = ++sample, .sample_time_ns = clock.now_ns()}, kAtW);
  }
  // Takes what is sent for that long.
  void receive_for(std::chrono::milliseconds time) {
    for (const auto end = std::chrono::steady_clock::now() + time; std::chrono::steady_clock::now() < end;) {
      want();
      for (const Message* part = sender.front(); part != nullptr; part = sender.front()) {
        if (const auto* tile = std::get_if<PatchTile>(part)) store.accept(*tile);
        if (const auto* cell = std::get_if<PatchCell>(part)) store.accept(*cell);
        if (const auto* begin = std::get_if<PatchBegin>(part)) store.accept(*begin);
        ++received;
        sender.pop();
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  }
  bool receive_until(const auto& holds) {
    for (int n = 0; n < 600 && !holds(); ++n) receive_for(std::chrono::milliseconds(50));
    return holds();
  }
  bool is_whole() const { return store.has_begun() && std::isinf(store.known_radius(Vec3::Zero())); }

  SteadyClock clock;
  PatchSender sender;
  PatchStore store;
  std::uint64_t sample = 0;
  int received = 0;
};

TEST(PatchSender, SendsNothingBeforeTheHubWantsIt) {
  SenderStage stage;
  stage.sender.note_hand({}, kAtW);
  std::this_thread::sleep_for(std::chrono::milliseconds(150));
  EXPECT_EQ(stage.sender.front(), nullptr);
  EXPECT_FALSE(stage.sender.is_wanted(stage.clock.now_ns()));
}

TEST(PatchSender, SendsTheWholeSceneAndThenNothingMore) {
  SenderStage stage;
  ASSERT_TRUE(stage.receive_until([&] { return stage.is_whole(); }));
  EXPECT_EQ(stage.store.begin().scene_hash, 7U);
  EXPECT_EQ(stage.store.make_piece(Vec3::Zero(), 1.0, 100'000).triangles, 800U);
  // What has come is confirmed; what was sent twice before is over.
  int before = -1;
  EXPECT_TRUE(stage.receive_until([&] {
    stage.receive_for(std::chrono::milliseconds(300));
    return std::exchange(before, stage.received) == stage.received;
  }));
  const PatchSource::Counts counts = stage.sender.counts();
  EXPECT_EQ(counts.held, counts.sent - counts.repeated);
}

TEST(PatchSender, StopsWhenTheHubDoesNotWantItAnyMore) {
  SenderStage stage;
  stage.want();
  EXPECT_TRUE(stage.sender.is_wanted(stage.clock.now_ns()));
  stage.sender.accept({}, stage.clock.now_ns());
  EXPECT_FALSE(stage.sender.is_wanted(stage.clock.now_ns()));
}

TEST(PatchSender, AMethodThatPartsDoNotServeGetsAnEpochWithoutAny) {
  SenderStage stage;
  ASSERT_TRUE(stage.receive_until([&] { return stage.is_whole(); }));
  const std::uint32_t epoch = stage.store.status().epoch;
  stage.sender.set_offered(false);
  ASSERT_TRUE(stage.receive_until([&] { return stage.store.status().epoch == epoch + 1; }));
  stage.receive_for(std::chrono::milliseconds(200));
  EXPECT_EQ(stage.store.make_piece(Vec3::Zero(), 1.0, 100'000).triangles, 0U);
  stage.sender.set_offered(true);
  EXPECT_TRUE(stage.receive_until([&] { return stage.store.status().epoch == epoch + 2 && stage.is_whole(); }));
}

// What a part says holds within its epoch, and a part has a material.
TEST(PatchSender, AWithdrawnSceneIsNotOfferedAgain) {
  SenderStage stage;
  ASSERT_TRUE(stage.receive_until([&] { return stage.is_whole(); }));
  const std::uint32_t epoch = stage.store.status().epoch;
  stage.sender.withdraw();
  stage.sender.set_offered(true);
  ASSERT_TRUE(stage.receive_until([&] { return stage.store.status().epoch == epoch + 1; }));
  stage.receive_for(std::chrono::milliseconds(200));
  EXPECT_EQ(stage.store.make_piece(Vec3::Zero(), 1.0, 100'000).triangles, 0U);
}

TEST(PatchSender, OtherMaterialsComeInAnEpochOfTheirOwn) {
  SenderStage stage;
  ASSERT_TRUE(stage.receive_until([&] { return stage.is_whole(); }));
  const std::uint32_t epoch = stage.store.status().epoch;
  stage.sender.set_materials({{.stiffness_n_per_m = 321.0, .friction_static = 0.3}});
  ASSERT_TRUE(stage.receive_until([&] { return stage.store.status().epoch == epoch + 1 && stage.is_whole(); }));
  const auto piece = stage.store.make_piece(Vec3::Zero(), 1.0, 100'000);
  ASSERT_EQ(piece.triangles, 800U);
  for (const TouchObject& object : piece.scene.objects) {
    EXPECT_EQ(object.material.stiffness_n_per_m, 321.0);
    EXPECT_EQ(object.material.friction_static, 0.3);
  }
}

// Parts hold no effects: without them the hub's own step would give other forces.
TEST(PatchSender, ASceneWithEffectsIsNeverOffered) {
  TouchScene scene = scene_of(made::sheet(0.05, 0.0, 20));
  scene.objects[0].effects.viscosity.damping_ns_per_m = 1.0;
  SenderStage stage(true, scene);
  stage.sender.set_offered(true);
  ASSERT_TRUE(stage.receive_until([&] { return stage.store.has_begun(); }));
  stage.receive_for(std::chrono::milliseconds(200));
  EXPECT_EQ(stage.store.make_piece(Vec3::Zero(), 1.0, 100'000).triangles, 0U);
}

// What moves would stand still in the parts that the hub keeps.
TEST(PatchSender, ASceneThatMovesIsNeverOffered) {
  TouchScene scene = scene_of(made::sheet(0.05, 0.0, 20));
  scene.objects[0].motion = std::make_shared<const KeyframeMotion>(
      Vec3::Zero(), std::vector<Keyframe>{{0.0, Vec3::Zero(), Quat::Identity()}, {1.0, Vec3::Zero(), Quat::Identity()}}, false);
  SenderStage stage(true, scene);
  stage.sender.set_offered(true);
  EXPECT_FALSE(stage.sender.is_offered());
  EXPECT_EQ(stage.sender.obstacle(), "objects of the scene move");
}

TEST(PatchSender, ASceneThatCanBeCarvedIsNeverOffered) {
  TouchScene scene = scene_of(made::sheet(0.05, 0.0, 20));
  scene.objects[0].sculpt = SculptSettings{.voxel_m = 0.001, .tool_radius_m = 0.004, .button = 1};
  SenderStage stage(true, scene);
  stage.sender.set_offered(true);
  EXPECT_FALSE(stage.sender.is_offered());
  EXPECT_EQ(stage.sender.obstacle(), "objects of the scene can be carved");
}

TEST(PatchSender, OffersWhatPartsServe) {
  EXPECT_TRUE(PatchSender::can_offer("name=proxy probe_radius_m=0"));
  EXPECT_FALSE(PatchSender::can_offer("name=proxy probe_radius_m=0 shading=0.5"));
  EXPECT_FALSE(PatchSender::can_offer("name=smooth"));
  EXPECT_FALSE(PatchSender::can_offer(std::string_view("\0name=proxy", 11)));
}

TEST(PatchSender, TheReplyLoopsCallsUseNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  SenderStage stage;
  stage.want();
  const PatchStatus status{.is_wanted = true};
  const AllocationGuard guard;
  for (int n = 0; n < 100; ++n) {
    stage.sender.accept(status, n);
    stage.sender.note_hand({}, kAtW);
    if (stage.sender.front() != nullptr) stage.sender.pop();
  }
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace hapton
