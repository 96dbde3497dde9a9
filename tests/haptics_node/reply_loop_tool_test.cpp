#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <string>
#include <string_view>
#include <thread>

#include "core/tool/held_tool.h"
#include "haptics_node/reply_loop.h"
#include "scene/scene_file.h"
#include "tests/haptics_node/reply_loop_stage.h"
#include "tests/standins/paths.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

Scene sheet_for_a_tool() {
  Scene scene;
  scene.objects.push_back({.name = "hull", .mesh = made::shared(made::sheet(0.1, 0.0, 6)), .material = {}});
  return scene;
}

HapticsSetup::Text describe_at(double n_per_m) {
  HapticsSetup::Text text = {};
  const std::string_view words = n_per_m > 1000.0 ? "name=tool hard" : "name=tool soft";
  std::copy(words.begin(), words.end(), text.begin());
  return text;
}

// The stylus holds a rigid tool, and an effect from a shared library acts as well.
class ToolLoopTest : public ReplyLoopStage {
 protected:
  ToolLoopTest() {
    step_.hold(&tool_);
    loop_.set_material_task(&material_task_);
    for (int i = 0; i < 10 && client_.state() != JoinState::joined; ++i) {
      loop_.turn(clock_.now_ns() + kMs);
      receive_at_hub();
    }
  }

  void take(const Message& message) override {
    if (const auto* setup = std::get_if<HapticsSetup>(&message)) setup_ = *setup;
    if (const auto* materials = std::get_if<MaterialState>(&message)) materials_ = *materials;
  }
  void exchange() {
    send(DeviceState{.sample = ++sample_, .sample_time_ns = clock_.now_ns(), .p_WD = Vec3(0.0, 0.0, 0.05)});
    loop_.turn(clock_.now_ns() + kMs);
    receive_at_hub();
  }
  std::string method() const { return setup_.method.data(); }

  Scene scene_ = sheet_for_a_tool();
  HeldTool tool_{
      std::move(*ToolStep::make(made::box(Vec3::Constant(-0.01), Vec3::Constant(0.01)), {scene_.touch_scene().objects[0].mesh}, {}))};
  HapticsStep step_{std::make_unique<TouchStep>(*make_method({}, scene_.touch_scene())), 1e-5};
  MethodBuilder builder_{{}, scene_.touch_scene()};
  ReplyLoop loop_{client_, clock_, step_, builder_, {.scene_hash = 42, .method = describe_at(1000.0)}};
  MaterialTask material_task_{scene_, 0.0, {}, describe_at};
  HapticsSetup setup_;
  MaterialState materials_;
  std::uint64_t sample_ = 0;
};

// A recording and a report need to know of these effects.
TEST_F(ToolLoopTest, EffectsFromFilesStayInTheSetupWhereMaterialsChange) {
  PluginEffects effects(clock_);
  ASSERT_TRUE(effects.add(*parse_plugin_choice(standin::library("plugins/odd_effect.so") + ":does=push")));
  step_.use_effects(&effects);
  loop_.set_effects(&effects);
  for (int n = 0; n < 1500; ++n) exchange();  // long enough: a setup is sent once a second
  EXPECT_EQ(method(), "name=tool soft" + effects.to_text());
  const MaterialRequest harder{.request = 7, .change = {.fields = MaterialChange::kStiffness, .stiffness_n_per_m = 1500.0}};
  for (int n = 0; n < 6000 && materials_.request != 7; ++n) {
    send(harder);
    exchange();
    std::this_thread::sleep_for(std::chrono::milliseconds(5));  // the thread of the material task needs real time
  }
  ASSERT_EQ(materials_.request, 7U);
  ASSERT_STREQ(materials_.rejection.data(), "");
  for (int n = 0; n < 300; ++n) exchange();
  EXPECT_EQ(method(), "name=tool hard" + effects.to_text());
}

}  // namespace
}  // namespace hapton
