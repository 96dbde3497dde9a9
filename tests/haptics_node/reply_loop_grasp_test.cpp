#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "core/base/button_bit.h"
#include "core/tool/held_tool.h"
#include "haptics_node/patch_sender.h"
#include "haptics_node/reply_loop.h"
#include "haptics_node/stiffness_adviser.h"
#include "patch/patch_store.h"
#include "plugin/plugin_effects.h"
#include "tests/haptics_node/reply_loop_stage.h"
#include "tests/standins/paths.h"
#include "tests/support/log_of.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

TouchScene two_boxes_of_loop() {
  TouchScene scene;
  scene.objects.push_back({made::shared(made::box(Vec3(-0.1, -0.1, -0.02), Vec3(0.1, 0.1, -0.01))), {}});
  scene.objects.push_back({made::shared(made::box(Vec3::Constant(-0.01), Vec3::Constant(0.01))), {}});
  return scene;
}

// The small box, as the tool that the stylus holds above the large one.
HeldTool make_small_box_tool() {
  return HeldTool(std::move(
      *ToolStep::make(made::box(Vec3(-0.01, -0.01, -0.0205), Vec3(0.01, 0.01, -0.0005)), {two_boxes_of_loop().objects[0].mesh}, {})));
}

// The test itself takes the place of the slow task of grasping.
class GraspLoopTest : public ReplyLoopStage {
 protected:
  explicit GraspLoopTest(std::int64_t start_ns = 0) {
    clock_.advance_ns(start_ns);
    step_.set_grasp(&grasp_);
    for (int i = 0; i < 10 && client_.state() != JoinState::joined; ++i) {
      loop_.turn(clock_.now_ns() + kMs);
      receive_at_hub();
    }
  }

  void take(const Message& message) override {
    if (const auto* setup = std::get_if<HapticsSetup>(&message)) {
      setup_ = *setup;
      posed_after_setup_.emplace_back();
    }
    if (const auto* pose = std::get_if<ObjectPose>(&message)) {
      if (pose->object == 1) pose_ = *pose;
      if (!posed_after_setup_.empty()) posed_after_setup_.back().push_back(pose->object);
    }
    if (const auto* command = std::get_if<ForceCommand>(&message)) {
      object_ = command->object;
      force_n_ = command->force_n[2];
    }
    if (const auto* scene = std::get_if<SceneFacts>(&message)) scene_ = *scene;
    if (const auto* materials = std::get_if<MaterialState>(&message)) materials_ = *materials;
    (void)store_.accept_part(message);
  }
  void exchange(const Vec3& p_WD, std::uint32_t buttons) {
    send(DeviceState{.sample = ++sample_, .sample_time_ns = clock_.now_ns(), .p_WD = p_WD, .buttons = buttons});
    loop_.turn(clock_.now_ns() + kMs);
    receive_at_hub();
  }
  // Touches the small box, picks it up, and gets the tool that is requested.
  void pick_up(HeldTool& tool) {
    for (int n = 0; n < 25; ++n) exchange({0.0, 0.0, 0.0119 - 1e-4 * n}, 0);
    ASSERT_EQ(object_, 1);
    exchange({0.0, 0.0, 0.0095}, 1);
    ASSERT_TRUE(link_.requests.take());
    link_.replies.publish({link_.requests.value().serial, &tool, {"name=tool"}});
  }
  // Holds the tool for `count` samples. Returns the method that the node names then.
  std::string hold(HeldTool& tool, int count) {
    for (int n = 0; n < count; ++n) {
      exchange({0.0, 0.0, 0.02}, 1);
      tool.follow();
    }
    return std::string(method());
  }
  std::string_view method() const { return setup_.method.data(); }
  // Builds the scene of that revision, with the box put down where it was.
  bool put_down(std::uint32_t revision) {
    auto made = std::make_shared<NewScene>();
    made->touch = two_boxes_of_loop();
    made->materials.resize(2);
    made->revision = revision;
    made->put_down_serial = 1;
    return builder_.rebuild_for(made).has_value();
  }

  GraspLink link_;
  Grasp grasp_{link_, {false, true}, button_bit(1)};
  HapticsStep step_{std::make_unique<TouchStep>(*make_method({}, two_boxes_of_loop())), 1e-5};
  MethodBuilder builder_{{}, two_boxes_of_loop()};
  ReplyLoop loop_{client_, clock_, step_, builder_, {.scene_hash = 42, .method = {"name=proxy"}}};
  HapticsSetup setup_;
  ObjectPose pose_;
  std::vector<std::vector<std::int32_t>> posed_after_setup_;  // for each setup: the objects whose poses came after it
  SceneFacts scene_;
  MaterialState materials_;
  PatchStore store_;
  std::int32_t object_ = -1;
  double force_n_ = 0.0;
  std::uint64_t sample_ = 0;
};

TEST_F(GraspLoopTest, AnObjectThatCannotBePutDownIsShownWhereItWasAndTheMethodIsThatBefore) {
  HeldTool tool = make_small_box_tool();
  for (int n = 0; n < 25; ++n) exchange({0.0, 0.0, 0.0119 - 1e-4 * n}, 0);
  ASSERT_EQ(object_, 1);
  EXPECT_EQ(method(), "name=proxy");
  exchange({0.0, 0.0, 0.0095}, 1);
  ASSERT_TRUE(link_.requests.take());
  ASSERT_EQ(link_.requests.value().kind, GraspRequest::Kind::pick_up);
  link_.replies.publish({link_.requests.value().serial, &tool, {"name=tool"}});
  for (int n = 0; n < 50; ++n) {
    exchange({2e-4 * n, 0.0, 0.02}, 1);
    tool.follow();
  }
  EXPECT_EQ(method(), "name=tool");
  EXPECT_TRUE(pose_.is_held);
  const std::uint32_t serial_before = setup_.method_serial;
  exchange({0.01, 0.0, 0.02}, 0);
  ASSERT_TRUE(link_.requests.take());
  ASSERT_EQ(link_.requests.value().kind, GraspRequest::Kind::put_down);
  link_.replies.publish({link_.requests.value().serial});
  for (int n = 0; n < 5; ++n) exchange({0.01, 0.0, 0.02}, 0);
  EXPECT_EQ(method(), "name=proxy");
  EXPECT_GT(setup_.method_serial, serial_before) << "for a recording, the method has changed";
  EXPECT_FALSE(pose_.is_held);
  EXPECT_EQ(pose_.p_m, Vec3(0.0, 0.0, 0.0));
  for (int n = 0; n < 200; ++n) exchange({0.01 - 5e-5 * n, 0.0, 0.02 - 5e-5 * n}, 0);
  for (int n = 0; n < 10; ++n) exchange({0.0, 0.0, 0.0095}, 0);
  EXPECT_EQ(object_, 1) << "felt where it is shown";
}

// The method was requested before the pick-up, or a scene was saved meanwhile. Replays must know that the forces are the tool's.
TEST_F(GraspLoopTest, AMethodThatIsBuiltWhileAnObjectIsHeldIsNamedOnceItIsPutDown) {
  HeldTool tool = make_small_box_tool();
  ASSERT_NO_FATAL_FAILURE(pick_up(tool));
  hold(tool, 50);
  ASSERT_EQ(method(), "name=tool");
  const std::uint32_t serial_before = setup_.method_serial;
  auto made = std::make_shared<NewScene>();
  made->touch = two_boxes_of_loop();
  made->materials.resize(2);
  made->revision = 1;
  ASSERT_TRUE(builder_.rebuild_for(made));
  hold(tool, 50);
  ASSERT_GT(setup_.method_serial, serial_before);
  EXPECT_EQ(method(), "name=tool");
  exchange({0.0, 0.0, 0.02}, 0);
  ASSERT_TRUE(link_.requests.take());
  link_.replies.publish({link_.requests.value().serial});
  for (int n = 0; n < 5; ++n) exchange({0.0, 0.0, 0.02}, 0);
  EXPECT_TRUE(method().starts_with("name=proxy")) << method();
}

// A recording and a report must name these effects.
TEST_F(GraspLoopTest, EffectsFromFilesAreNamedBesideTheToolWhileAnObjectIsHeld) {
  PluginEffects effects(clock_);
  ASSERT_TRUE(effects.add(*parse_plugin_choice(standin::library("plugins/odd_effect.so") + ":does=nan,after=100")));
  step_.use_effects(&effects);
  loop_.set_effects(&effects);
  HeldTool tool = make_small_box_tool();
  ASSERT_NO_FATAL_FAILURE(pick_up(tool));
  const std::string method_while_held = hold(tool, 50);
  EXPECT_TRUE(method_while_held.starts_with("name=tool effects=odd_one@")) << method_while_held;
  EXPECT_EQ(method_while_held.find("!cut"), std::string::npos) << method_while_held;
  const std::string method_after_cut = hold(tool, 150);
  EXPECT_TRUE(method_after_cut.starts_with("name=tool effects=odd_one@")) << method_after_cut;
  EXPECT_NE(method_after_cut.find("!cut"), std::string::npos) << method_after_cut;
  exchange({0.0, 0.0, 0.02}, 0);
  ASSERT_TRUE(link_.requests.take());
  link_.replies.publish({link_.requests.value().serial});
  for (int n = 0; n < 5; ++n) exchange({0.0, 0.0, 0.02}, 0);
  EXPECT_TRUE(method().starts_with("name=proxy effects=odd_one@")) << method();
}

// A datagram may be lost, so poses are sent again: of many objects, some with each setup.
TEST_F(GraspLoopTest, SixteenPosesAreSentInTurnWithEachSetup) {
  Grasp few(link_, {true, false, true}, button_bit(1));
  step_.set_grasp(&few);
  posed_after_setup_.clear();
  for (int n = 0; n < 20'000 && posed_after_setup_.size() < 2; ++n) exchange({0.0, 0.0, 0.05}, 0);
  ASSERT_EQ(posed_after_setup_.size(), 2U);
  EXPECT_EQ(posed_after_setup_.front().size(), 2U) << "each once";
  std::vector<bool> movable(21, true);
  movable[3] = false;
  Grasp many(link_, movable, button_bit(1));
  step_.set_grasp(&many);
  posed_after_setup_.clear();
  for (int n = 0; n < 20'000 && posed_after_setup_.size() < 4; ++n) exchange({0.0, 0.0, 0.05}, 0);
  ASSERT_EQ(posed_after_setup_.size(), 4U);
  posed_after_setup_.pop_back();
  std::int32_t next = 0;
  for (const std::vector<std::int32_t>& objects : posed_after_setup_) {
    EXPECT_EQ(objects.size(), 16U);
    for (const std::int32_t object : objects) {
      if (next == 3) ++next;
      EXPECT_EQ(object, next);
      next = (next + 1) % 21;
    }
  }
  step_.set_grasp(&grasp_);
}

// Hash and facts of a scene may be known before or after that scene comes into use. They are sent once both are true.
TEST_F(GraspLoopTest, ASceneWithAnObjectPutDownIsDescribedOnceItsHashIsKnown) {
  exchange({0.0, 0.0, 0.05}, 0);
  exchange({0.0, 0.0, 0.05}, 0);
  EXPECT_EQ(setup_.scene_hash, 42U);
  SceneFacts facts;
  facts.given_hash = 7;
  link_.placed.publish({1, 43, facts});
  for (int n = 0; n < 5; ++n) exchange({0.0, 0.0, 0.05}, 0);
  EXPECT_EQ(setup_.scene_hash, 42U) << "not in use yet";
  ASSERT_TRUE(put_down(1));
  for (int n = 0; n < 5; ++n) exchange({0.0, 0.0, 0.05}, 0);
  EXPECT_EQ(step_.counts().method_changes, 1U);
  EXPECT_EQ(setup_.scene_hash, 43U);
  EXPECT_EQ(scene_.given_hash, 7U);
  ASSERT_TRUE(put_down(2));
  for (int n = 0; n < 5; ++n) exchange({0.0, 0.0, 0.05}, 0);
  EXPECT_EQ(step_.counts().method_changes, 2U);
  EXPECT_EQ(setup_.scene_hash, 0U) << "not known yet: the hash before is that of another scene";
  EXPECT_EQ(setup_.method_serial, 2U);
  link_.placed.publish({2, 44, facts});
  for (int n = 0; n < 5; ++n) exchange({0.0, 0.0, 0.05}, 0);
  EXPECT_EQ(setup_.scene_hash, 44U);
}

// The objects are the same: they keep the stiffness that they were given, from the first force in the new scene on.
TEST_F(GraspLoopTest, WhereAnObjectIsPutDownMaterialsStayAsTheyWereChanged) {
  constexpr double kDepth = 0.002;
  Scene named;
  for (const TouchObject& object : two_boxes_of_loop().objects)
    named.objects.push_back({.name = "box", .mesh = object.mesh, .material = {}});
  MaterialTask material_task(named, 0.0);
  loop_.set_material_task(&material_task);
  const auto press = [&](int count) {
    for (int n = 0; n < count; ++n) exchange({0.0, 0.0, 0.01 - kDepth}, 0);
  };
  const auto stiffen = [&](std::uint32_t number, double n_per_m) {
    for (int i = 0; i < 6000 && materials_.request != number; ++i) {
      send(MaterialRequest{.request = number, .change = {.fields = MaterialChange::kStiffness, .stiffness_n_per_m = n_per_m}});
      press(1);
      std::this_thread::sleep_for(std::chrono::milliseconds(5));  // material_task works in real time
    }
    press(120);  // until the force has faded
    EXPECT_STREQ(materials_.rejection.data(), "");
    EXPECT_NEAR(force_n_, n_per_m * kDepth, 1e-4);
  };
  exchange({0.0, 0.0, 0.015}, 0);
  press(1);
  stiffen(1, 1500.0);
  const std::uint32_t before = materials_.serial;
  ASSERT_TRUE(put_down(1));
  for (int n = 0; n < 200; ++n) {
    press(1);
    ASSERT_NEAR(force_n_, 1500.0 * kDepth, 1e-4) << n;
  }
  ASSERT_EQ(step_.counts().method_changes, 1U);
  EXPECT_GT(materials_.serial, before);
  ASSERT_EQ(materials_.object_count, 1U) << "for recordings and tools";
  EXPECT_EQ(materials_.objects[0].change.stiffness_n_per_m, 1500.0);
  stiffen(2, 800.0);  // material_task still has the scene from before, whose materials are the same
}

// The hub computes forces, with parts from a thread in real time. The simulated time of the test is far ahead of that.
class WithdrawnPartsTest : public GraspLoopTest {
 protected:
  WithdrawnPartsTest() : GraspLoopTest(100'000'000'000'000'000) { loop_.set_patch_sender(&patches_); }
  ~WithdrawnPartsTest() override { loop_.set_patch_sender(nullptr); }

  void turn(std::uint32_t buttons) {
    send_status();
    exchange({0.0, 0.0, 0.0095}, buttons);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  void send_status() {
    PatchStatus status = store_.status();
    status.is_wanted = true;
    status.request = request_;
    send(status);
  }
  // While the hub computes the force, samples are rare.
  void turn_without_sample() {
    loop_.turn(clock_.now_ns() + kMs);
    receive_at_hub();
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  bool turn_until(std::uint32_t buttons, const auto& holds) {
    for (int n = 0; n < 3000 && !holds(); ++n) turn(buttons);
    return holds();
  }
  bool is_whole() const { return store_.has_begun() && std::isinf(store_.known_radius(Vec3::Zero())); }
  bool is_empty() const { return store_.has_begun() && store_.make_piece(Vec3::Zero(), 1.0, 1000).triangles == 0; }
  void touch() {
    for (int n = 0; n < 25; ++n) exchange({0.0, 0.0, 0.0119 - 1e-4 * n}, 0);
    ASSERT_EQ(object_, 1);
  }

  PatchSender patches_{two_boxes_of_loop(), 0.0, 42, true, {.bits_per_s = 1e8, .least_reach_m = 1.0}};
  HeldTool tool_ = make_small_box_tool();
  std::uint32_t request_ = 5;
};

// When states are rare, the hand may go far between two. A gap among frequent states is another case, though the hub wants parts.
TEST_F(WithdrawnPartsTest, BetweenFewStatesTheHandIsFollowedAndAcrossAGapItIsNot) {
  const auto go_to = [&](double z_m, std::int64_t after_ns) {
    send_status();
    clock_.advance_ns(after_ns);
    exchange({0.0, 0.0, z_m}, 0);
  };
  go_to(0.03, 0);
  go_to(0.03, 0);
  go_to(-0.005, 50 * kMs);
  EXPECT_EQ(object_, -1) << "it may have gone around the box";
  go_to(0.03, 0);
  go_to(0.03, 50 * kMs);
  go_to(-0.005, 50 * kMs);
  EXPECT_EQ(object_, 1);
  EXPECT_NEAR(force_n_, 15.0, 0.1);
}

TEST_F(WithdrawnPartsTest, AnObjectIsPickedUpOnceTheHubHasConfirmedThatItHasNoParts) {
  touch();
  ASSERT_TRUE(turn_until(0, [&] { return is_whole(); }));
  turn(1);
  ASSERT_TRUE(link_.requests.take());
  for (int n = 0; n < 50; ++n) turn(1);
  EXPECT_FALSE(is_empty()) << "it may turn out that it cannot be picked up";
  link_.replies.publish({link_.requests.value().serial, &tool_, {"name=tool"}});
  // The hub gets the epoch without parts, and its confirmation is lost.
  for (int n = 0; n < 2000 && !is_empty(); ++n) {
    exchange({0.0, 0.0, 0.0095}, 1);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  ASSERT_TRUE(is_empty());
  for (int n = 0; n < 50; ++n) exchange({0.0, 0.0, 0.0095}, 1);
  EXPECT_FALSE(step_.holds_tool());
  EXPECT_FALSE(pose_.is_held);
  EXPECT_EQ(object_, 1) << "and is felt where it lies";
  ASSERT_TRUE(turn_until(1, [&] { return step_.holds_tool(); }));
  for (int n = 0; n < 50; ++n) turn(1);
  EXPECT_TRUE(is_empty());
}

// If parts of the object's old place come late, an older hub takes them for parts of the new place.
TEST_F(WithdrawnPartsTest, AnOlderHubGetsNoParts) {
  request_ = 0;
  touch();
  const std::string log = log_of([&] {
    ASSERT_TRUE(turn_until(0, [&] { return is_empty(); }));
    for (int n = 0; n < 100; ++n) turn(0);
  });
  EXPECT_NE(log.find("objects of the scene are movable, and io_node is of an older version"), std::string::npos) << log;
  EXPECT_TRUE(is_empty());
  turn(1);
  ASSERT_TRUE(link_.requests.take());
  link_.replies.publish({link_.requests.value().serial, &tool_, {"name=tool"}});
  turn(1);
  turn(1);
  EXPECT_TRUE(step_.holds_tool()) << "without waiting";
}

TEST_F(WithdrawnPartsTest, AnOlderHubGetsNoPartsBeforeTheFirstSampleEither) {
  request_ = 0;
  for (int n = 0; n < 300; ++n) {
    send_status();
    turn_without_sample();
    ASSERT_FALSE(store_.has_begun() && !is_empty()) << n;
  }
  EXPECT_TRUE(store_.has_begun());
}

TEST_F(WithdrawnPartsTest, PartsAreWithdrawnWithoutWaitingForASample) {
  touch();
  ASSERT_TRUE(turn_until(0, [&] { return is_whole(); }));
  turn(1);
  ASSERT_TRUE(link_.requests.take());
  link_.replies.publish({link_.requests.value().serial, &tool_, {"name=tool"}});
  for (int n = 0; n < 2000 && !is_empty(); ++n) turn_without_sample();
  ASSERT_TRUE(is_empty());
  EXPECT_FALSE(step_.holds_tool());
  send_status();
  exchange({0.0, 0.0, 0.0095}, 1);
  EXPECT_TRUE(step_.holds_tool());
}

// The force is remote here: the control loop contains the round trip, and a move may begin before the hub knows of it.
TEST_F(WithdrawnPartsTest, WhereTheHubHasNoPartsTheLoopIsThatOfRemoteForce) {
  const auto log_of_advice = [&](std::uint32_t buttons) {
    return log_of([&] {
      StiffnessAdviser adviser({.stiffness_n_per_m = 1e6});
      loop_.set_stiffness_adviser(&adviser);
      for (int n = 0; n < 5; ++n) {
        send(LoopFacts{.device = {'s', 'i', 'm', 'u', 'l', 'a', 't', 'e', 'd'}, .servo_rate_hz = 1000.0, .round_trip_s = 0.010F});
        turn(buttons);
      }
      const std::uint64_t before = adviser.checks();
      for (int n = 0; n < 6000 && adviser.checks() < before + 2; ++n) std::this_thread::sleep_for(std::chrono::milliseconds(5));
      loop_.set_stiffness_adviser(nullptr);
    });
  };
  touch();
  ASSERT_TRUE(turn_until(0, [&] { return is_whole(); }));
  EXPECT_EQ(log_of_advice(0).find("stiffness"), std::string::npos);
  EXPECT_GT(patches_.find_lead_ns(clock_.now_ns()), 0);
  turn(1);
  ASSERT_TRUE(link_.requests.take());
  link_.replies.publish({link_.requests.value().serial, &tool_, {"name=tool"}});
  loop_.turn(clock_.now_ns() + kMs);
  EXPECT_GT(patches_.find_lead_ns(clock_.now_ns()), 0) << "the hub has not confirmed yet that it has none";
  ASSERT_TRUE(turn_until(1, [&] { return step_.holds_tool(); }));
  EXPECT_EQ(patches_.find_lead_ns(clock_.now_ns()), 0);
  EXPECT_NE(log_of_advice(1).find("stiffness"), std::string::npos);
}

}  // namespace
}  // namespace hapton
