#include <gtest/gtest.h>

#include <memory>
#include <string_view>
#include <vector>

#include "core/base/button_bit.h"
#include "core/tool/held_tool.h"
#include "haptics_node/reply_loop.h"
#include "tests/haptics_node/reply_loop_stage.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

TouchScene two_boxes_of_loop() {
  TouchScene scene;
  scene.objects.push_back({made::shared(made::box(Vec3(-0.1, -0.1, -0.02), Vec3(0.1, 0.1, -0.01))), {}});
  scene.objects.push_back({made::shared(made::box(Vec3::Constant(-0.01), Vec3::Constant(0.01))), {}});
  return scene;
}

// The test is the slow task of grasping.
class GraspLoopTest : public ReplyLoopStage {
 protected:
  GraspLoopTest() {
    step_.set_grasp(&grasp_);
    for (int i = 0; i < 10 && client_.state() != JoinState::joined; ++i) {
      loop_.turn(clock_.now_ns() + kMs);
      receive_at_hub();
    }
  }

  void take(const Message& message) override {
    if (const auto* setup = std::get_if<HapticsSetup>(&message)) setup_ = *setup;
    if (const auto* pose = std::get_if<ObjectPose>(&message); pose != nullptr && pose->object == 1) pose_ = *pose;
    if (const auto* command = std::get_if<ForceCommand>(&message)) object_ = command->object;
    if (const auto* scene = std::get_if<SceneFacts>(&message)) scene_ = *scene;
  }
  void exchange(const Vec3& p_WD, std::uint32_t buttons) {
    send(DeviceState{.sample = ++sample_, .sample_time_ns = clock_.now_ns(), .p_WD = p_WD, .buttons = buttons});
    loop_.turn(clock_.now_ns() + kMs);
    receive_at_hub();
  }
  std::string_view method() const { return setup_.method.data(); }

  GraspLink link_;
  Grasp grasp_{link_, {false, true}, button_bit(1)};
  HapticsStep step_{std::make_unique<TouchStep>(*make_method({}, two_boxes_of_loop())), 1e-5};
  MethodBuilder builder_{{}, two_boxes_of_loop()};
  ReplyLoop loop_{client_, clock_, step_, builder_, {.scene_hash = 42, .method = {"name=proxy"}}};
  HapticsSetup setup_;
  ObjectPose pose_;
  SceneFacts scene_;
  std::int32_t object_ = -1;
  std::uint64_t sample_ = 0;
};

TEST_F(GraspLoopTest, AnObjectThatCannotBePutDownIsShownWhereItWasAndTheMethodIsThatBefore) {
  HeldTool tool(std::move(
      *ToolStep::make(made::box(Vec3(-0.01, -0.01, -0.0205), Vec3(0.01, 0.01, -0.0005)), {two_boxes_of_loop().objects[0].mesh}, {})));
  for (int n = 0; n < 25; ++n) exchange({0.0, 0.0, 0.0119 - 1e-4 * n}, 0);
  ASSERT_EQ(object_, 1);
  EXPECT_EQ(method(), "name=proxy");
  exchange({0.0, 0.0, 0.0095}, 1);
  ASSERT_TRUE(link_.orders.take());
  ASSERT_EQ(link_.orders.value().kind, GraspOrder::Kind::pick_up);
  link_.replies.publish({link_.orders.value().serial, &tool, {"name=tool"}});
  for (int n = 0; n < 50; ++n) {
    exchange({2e-4 * n, 0.0, 0.02}, 1);
    tool.follow();
  }
  EXPECT_EQ(method(), "name=tool");
  EXPECT_TRUE(pose_.is_held);
  const std::uint32_t methods = setup_.method_serial;
  exchange({0.01, 0.0, 0.02}, 0);
  ASSERT_TRUE(link_.orders.take());
  ASSERT_EQ(link_.orders.value().kind, GraspOrder::Kind::put_down);
  link_.replies.publish({link_.orders.value().serial});
  for (int n = 0; n < 5; ++n) exchange({0.01, 0.0, 0.02}, 0);
  EXPECT_EQ(method(), "name=proxy");
  EXPECT_GT(setup_.method_serial, methods) << "to a recording it is another one than the tool";
  EXPECT_FALSE(pose_.is_held);
  EXPECT_EQ(pose_.p_m, Vec3(0.0, 0.0, 0.0));
  for (int n = 0; n < 200; ++n) exchange({0.01 - 5e-5 * n, 0.0, 0.02 - 5e-5 * n}, 0);
  for (int n = 0; n < 10; ++n) exchange({0.0, 0.0, 0.0095}, 0);
  EXPECT_EQ(object_, 1) << "felt where it is shown";
}

// Hash and facts of the scene come some time after it is felt, and not before it is in use.
TEST_F(GraspLoopTest, ASceneWithAnObjectPutDownIsDescribedOnceThatIsKnown) {
  exchange({0.0, 0.0, 0.05}, 0);
  exchange({0.0, 0.0, 0.05}, 0);
  EXPECT_EQ(setup_.scene_hash, 42U);
  SceneFacts facts;
  facts.given_hash = 7;
  link_.placed.publish({1, 43, facts});
  for (int n = 0; n < 5; ++n) exchange({0.0, 0.0, 0.05}, 0);
  EXPECT_EQ(setup_.scene_hash, 42U) << "not in use yet";
  auto made = std::make_shared<NewScene>();
  made->touch = two_boxes_of_loop();
  made->materials.resize(2);
  made->revision = 1;
  made->put_down = 1;
  ASSERT_TRUE(builder_.follow(made));
  for (int n = 0; n < 5; ++n) exchange({0.0, 0.0, 0.05}, 0);
  EXPECT_EQ(step_.counts().methods_taken, 1U);
  EXPECT_EQ(setup_.scene_hash, 43U);
  EXPECT_EQ(scene_.given_hash, 7U);
  made = std::make_shared<NewScene>(*made);
  made->revision = 2;
  ASSERT_TRUE(builder_.follow(made));
  for (int n = 0; n < 5; ++n) exchange({0.0, 0.0, 0.05}, 0);
  EXPECT_EQ(step_.counts().methods_taken, 2U);
  EXPECT_EQ(setup_.scene_hash, 43U) << "not known yet";
  link_.placed.publish({2, 44, facts});
  for (int n = 0; n < 5; ++n) exchange({0.0, 0.0, 0.05}, 0);
  EXPECT_EQ(setup_.scene_hash, 44U);
}

}  // namespace
}  // namespace hapton
