#include "haptics_node/tool_task.h"

#include <chrono>
#include <string>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "runtime/log.h"
#include "scene/object_reader.h"
#include "tests/support/made_meshes.h"
#include "tests/support/patience.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr char kLeftOut[] = "two_sided = false, images and effects of surfaces but viscosity_ns_per_m are ignored";

// A ball with a radius of 5 cm, felt with a cube of 1 cm.
Scene scene_with_tool() {
  Scene scene;
  SceneObject ball;
  ball.mesh = made::shared(made::sphere(0.05, 8));
  scene.objects = {ball};
  scene.tool = SceneTool{.name = "cube", .mesh = made::shared(made::box(Vec3::Constant(-0.005), Vec3::Constant(0.005)))};
  return scene;
}

std::string log_of_making_tool(const Scene& scene) {
  testing::internal::CaptureStderr();
  start_log("haptics_node");
  const auto tool = make_live_tool({}, scene);
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_TRUE(tool && *tool) << (tool ? "no tool" : tool.error().what);
  return log;
}

TEST(HeldToolOfAScene, NamesWhatOfTheSceneIsLeftOut) {
  Scene scene = scene_with_tool();
  EXPECT_THAT(log_of_making_tool(scene), Not(HasSubstr(kLeftOut)));
  EXPECT_THAT(log_of_making_tool(scene), HasSubstr("the stylus holds cube"));
  scene.objects[0].material.damping_ns_per_m = 0.5;
  scene.objects[0].effects.viscosity.damping_ns_per_m = 1.0;
  EXPECT_THAT(log_of_making_tool(scene), Not(HasSubstr(kLeftOut))) << "a tool has damping and viscosity";
  scene.objects[0].effects.progressive.n_per_m2 = 1e4;
  EXPECT_THAT(log_of_making_tool(scene), HasSubstr(kLeftOut)) << "the effect of a surface";
  scene = scene_with_tool();
  scene.objects[0].effects.maps.viscosity = {
      .image = std::make_shared<const SurfaceImage>(1, 1, std::vector<float>{0.5F}), .at_black = 7.0, .at_white = 2.0};
  EXPECT_THAT(log_of_making_tool(scene), HasSubstr(kLeftOut)) << "viscosity by an image";
  scene = scene_with_tool();
  scene.effects.emplace_back();
  EXPECT_THAT(log_of_making_tool(scene), Not(HasSubstr(kLeftOut))) << "an effect in space acts on a tool";
  scene = scene_with_tool();
  scene.objects[0].material.two_sided = false;
  EXPECT_THAT(log_of_making_tool(scene), HasSubstr(kLeftOut)) << "a surface felt from one side";
}

TEST(HeldToolOfAScene, HasTheDampingOfTheMaterials) {
  Scene scene = scene_with_tool();
  EXPECT_FALSE(make_live_tool({}, scene).value().followed->tool().damping().is_on());
  scene.objects[0].material.damping_ns_per_m = 0.5;
  EXPECT_TRUE(make_live_tool({}, scene).value().followed->tool().damping().is_on());
}

TEST(HeldToolOfAScene, IsAbsentIfTheSceneNamesNone) {
  Scene scene = scene_with_tool();
  scene.tool.reset();
  const auto tool = make_live_tool({}, scene);
  ASSERT_TRUE(tool);
  EXPECT_FALSE(*tool);
}

TEST(HeldToolOfAScene, IsRejectedWithOptionsOfAProbe) {
  HapticsOptions ball;
  ball.method.probe_radius_m = 0.001;
  ball.is_radius_given = true;
  const auto with_probe = make_live_tool(ball, scene_with_tool());
  ASSERT_FALSE(with_probe);
  EXPECT_THAT(with_probe.error().what, HasSubstr("--probe-radius"));
  HapticsOptions smooth;
  smooth.method.name = "smooth";
  smooth.is_method_given = true;
  const auto with_method = make_live_tool(smooth, scene_with_tool());
  ASSERT_FALSE(with_method);
  EXPECT_THAT(with_method.error().what, HasSubstr("method smooth needs one"));
  HapticsOptions shaded;
  shaded.method.shading = 1.0;
  EXPECT_TRUE(make_live_tool(shaded, scene_with_tool())) << "that of the scene's probe";
  shaded.is_shading_given = true;
  const auto with_shading = make_live_tool(shaded, scene_with_tool());
  ASSERT_FALSE(with_shading);
  EXPECT_THAT(with_shading.error().what, HasSubstr("--shading"));
}

TEST(HeldToolOfAScene, ItsOptionsAreRejectedWhereNothingIsHeld) {
  Scene scene = scene_with_tool();
  scene.tool.reset();
  HapticsOptions stiff;
  stiff.tool_nm_per_rad = 1.0;
  HapticsOptions shared;
  shared.tool_threads = 2;
  ASSERT_FALSE(make_live_tool(stiff, scene));
  ASSERT_FALSE(make_live_tool(shared, scene));
  EXPECT_THAT(make_live_tool(stiff, scene).error().what, HasSubstr("--rotational-stiffness"));
  EXPECT_THAT(make_live_tool(shared, scene).error().what, HasSubstr("--tool-threads"));
  scene.objects[0].is_movable = true;
  EXPECT_TRUE(make_live_tool(stiff, scene)) << "it is held with that stiffness";
  EXPECT_TRUE(make_live_tool(shared, scene));
}

TEST(HeldToolOfAScene, AnOddSizeIsLogged) {
  Scene scene = scene_with_tool();
  scene.tool->mesh = made::shared(made::box(Vec3::Constant(-5e-6), Vec3::Constant(5e-6)));
  EXPECT_THAT(log_of_making_tool(scene), HasSubstr("the tool is 0.01 mm long, the scene 100 mm; check the units"));
}

HapticsOptions with_voxels(double voxel_m) {
  HapticsOptions options;
  options.tool_voxel_m = voxel_m;
  return options;
}

TEST(ToolByVoxels, IsFeltWithoutASlowTask) {
  const auto tool = make_live_tool(with_voxels(0.0005), scene_with_tool());
  ASSERT_TRUE(tool && *tool);
  EXPECT_EQ(tool->followed, nullptr);
  EXPECT_THAT(tool->describe(500.0).data(), HasSubstr("name=tool stiffness_n_per_m=500 "));
  EXPECT_THAT(tool->describe(500.0).data(), HasSubstr("voxel_m=0.0005"));
  ToolInput input;
  ToolOutput felt;
  for (int n = 0; n < 400; ++n) {
    input.X_WD.translation().z() = 0.06 - 2e-5 * n;  // the bottom of the cube meets the ball at z = 0.055
    felt = tool->felt->step(input, 1'000'000 * n);
  }
  EXPECT_TRUE(felt.contact);
  EXPECT_GT(felt.force_n.z(), 0.1);
}

// Surfaces that are twice as stiff make turning the tool twice as stiff. The other gains are those of the scene.
TEST(HeldToolOfAScene, ItsGainsFollowTheMaterials) {
  Scene scene = scene_with_tool();
  scene.objects[0].material.stiffness_n_per_m = 500.0;
  const auto tool = make_live_tool({}, scene);
  ASSERT_TRUE(tool && *tool);
  EXPECT_EQ(find_gains(*tool, scene.touch_scene()).rotational_nm_per_rad, tool->coupling.rotational_stiffness_nm_per_rad);
  scene.objects[0].material.stiffness_n_per_m = 1000.0;
  scene.objects[0].material.damping_ns_per_m = 2.0;
  const LargestGains gains = find_gains(*tool, scene.touch_scene());
  EXPECT_DOUBLE_EQ(gains.rotational_nm_per_rad, 2.0 * tool->coupling.rotational_stiffness_nm_per_rad);
  EXPECT_EQ(gains.stiffness_n_per_m, 1000.0);
  EXPECT_EQ(gains.viscosity_ns_per_m, 2.0);
}

TEST(ToolByVoxels, NamesWhatVoxelsDoNotHave) {
  Scene scene = scene_with_tool();
  scene.objects[0].material.friction_static = scene.objects[0].material.friction_dynamic = 0.3;
  scene.objects[0].material.damping_ns_per_m = 0.5;
  testing::internal::CaptureStderr();
  start_log("haptics_node");
  ASSERT_TRUE(make_live_tool(with_voxels(0.001), scene));
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_THAT(log, HasSubstr("voxels have no friction"));
  EXPECT_THAT(log, HasSubstr("voxels have no damping"));
  EXPECT_THAT(log, HasSubstr("tool by voxels of 1 mm"));
}

TEST(ToolByVoxels, IsRejectedWhereItCannotBe) {
  Scene scene = scene_with_tool();
  HapticsOptions shared = with_voxels(0.001);
  shared.tool_threads = 2;
  const auto with_threads = make_live_tool(shared, scene);
  ASSERT_FALSE(with_threads);
  EXPECT_THAT(with_threads.error().what, HasSubstr("--tool-threads"));
  const auto too_fine = make_live_tool(with_voxels(1e-7), scene);
  ASSERT_FALSE(too_fine);
  EXPECT_THAT(too_fine.error().what, HasSubstr("fits"));
  ObjectSpec spec;
  spec.motion.by_program = true;
  scene.objects[0].commanded = std::make_shared<const CommandedObject>(spec, SceneFit(), *scene.objects[0].mesh);
  const auto moving = make_live_tool(with_voxels(0.001), scene);
  ASSERT_FALSE(moving);
  EXPECT_THAT(moving.error().what, HasSubstr("objects of the scene move"));
  scene = scene_with_tool();
  scene.tool.reset();
  scene.objects[0].is_movable = true;
  const auto without = make_live_tool(with_voxels(0.001), scene);
  ASSERT_FALSE(without);
  EXPECT_THAT(without.error().what, HasSubstr("--tool-voxels"));
}

// A scene may describe probes as well, for those who hold no tool.
TEST(ToolTask, IgnoresWhatTheScenesProbeSays) {
  HapticsOptions of_the_probe;
  of_the_probe.method.name = "smooth";
  of_the_probe.method.probe_radius_m = 0.003;
  const auto tool = make_live_tool(of_the_probe, scene_with_tool());
  ASSERT_TRUE(tool) << tool.error().what;
  EXPECT_TRUE(*tool);
}

TEST(ToolTask, FollowsTheHandUntilItIsStopped) {
  auto tool = make_live_tool({}, scene_with_tool());
  ASSERT_TRUE(tool && *tool);
  ToolTask task(*tool->followed);
  std::int64_t sample = 0;
  ToolInput input;
  const auto go_on = [&](int steps) {
    for (int n = 0; n < steps; ++n) {
      input.X_WD.translation().z() -= 1e-5;
      tool->felt->step(input, 1'000'000 * ++sample);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  };
  input.X_WD.translation().z() = 0.1;
  go_on(100);
  // A step knows where the tool is only after the task has followed a pose.
  EXPECT_TRUE(wait_until([&] {
    go_on(1);
    return tool->felt->is_known();
  }));
  task.stop();
  const auto poses = task.pose_times().count();
  EXPECT_GE(poses, 1U);
  EXPECT_LE(poses, static_cast<std::uint64_t>(sample)) << "more than there were samples";
  go_on(5);
  EXPECT_EQ(task.pose_times().count(), poses);
}

}  // namespace
}  // namespace hapton
