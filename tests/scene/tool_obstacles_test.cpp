#include "scene/tool_obstacles.h"

#include <gtest/gtest.h>

#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

// Three spheres, each with its own stiffness and friction.
TouchScene three_spheres() {
  TouchScene scene;
  for (int i = 0; i < 3; ++i) {
    TouchObject object;
    object.mesh = made::shared(made::sphere(0.01 * (i + 1), 8));
    object.material.stiffness_n_per_m = 100.0 * (i + 1);
    object.material.friction_static = 0.2 * i;
    object.material.friction_dynamic = 0.1 * i;
    scene.objects.push_back(object);
  }
  return scene;
}

TEST(ToolObstacles, AreTheObjectsWithTheirFriction) {
  const TouchScene scene = three_spheres();
  const ToolObstacles obstacles = make_tool_obstacles(scene);
  ASSERT_EQ(obstacles.meshes.size(), 3U);
  ASSERT_EQ(obstacles.friction.size(), 3U);
  for (std::size_t o = 0; o < 3; ++o) {
    EXPECT_EQ(obstacles.meshes[o], scene.objects[o].mesh);
    EXPECT_EQ(obstacles.friction[o].friction_static, scene.objects[o].material.friction_static);
    EXPECT_EQ(obstacles.friction[o].friction_dynamic, scene.objects[o].material.friction_dynamic);
  }
  EXPECT_EQ(obstacles.stiffness_n_per_m, 300.0);
}

TEST(ToolObstacles, LeaveOutTheHeldObjectButNotItsStiffness) {
  const TouchScene scene = three_spheres();
  const ToolObstacles obstacles = make_tool_obstacles(scene, 2);
  ASSERT_EQ(obstacles.meshes.size(), 2U);
  EXPECT_EQ(obstacles.meshes[0], scene.objects[0].mesh);
  EXPECT_EQ(obstacles.meshes[1], scene.objects[1].mesh);
  ASSERT_EQ(obstacles.friction.size(), 2U);
  EXPECT_EQ(obstacles.friction[1].friction_static, 0.2);
  EXPECT_EQ(obstacles.stiffness_n_per_m, 300.0) << "the held object is as stiff as it was to a probe";
}

TEST(ToolObstacles, AreInPartsThatMoveTogether) {
  TouchScene scene = three_spheres();
  scene.objects.push_back(scene.objects[0]);
  EXPECT_EQ(make_tool_obstacles(scene).part_of, std::vector<int>(4, 0));
  EXPECT_TRUE(make_tool_obstacles(scene).parts.empty());
  const auto motion = [](double z) {
    return std::make_shared<const KeyframeMotion>(
        Vec3::Zero(), std::vector<Keyframe>{{0.0, Vec3::Zero(), Quat::Identity()}, {1.0, {0.0, 0.0, z}, Quat::Identity()}}, false);
  };
  scene.objects[0].motion = motion(1.0);
  scene.objects[1].command_pivot = Vec3::Zero();
  scene.objects[3].motion = motion(1.0);
  const ToolObstacles obstacles = make_tool_obstacles(scene);
  EXPECT_EQ(obstacles.part_of, std::vector<int>({1, 2, 0, 1}));
  ASSERT_EQ(obstacles.parts.size(), 2U);
  EXPECT_EQ(obstacles.parts[0].pose_at(0.5).translation(), Vec3(0.0, 0.0, 0.5));
  EXPECT_EQ(obstacles.parts[0].commanded, -1);
  EXPECT_EQ(obstacles.parts[1].commanded, 1);
  EXPECT_EQ(obstacles.parts[1].pose_at(0.5).translation(), Vec3(Vec3::Zero()));
}

TEST(ToolObstacles, SayWhetherAnyHasFriction) {
  TouchScene scene = three_spheres();
  EXPECT_TRUE(make_tool_obstacles(scene).has_friction());
  scene.objects.resize(1);
  EXPECT_FALSE(make_tool_obstacles(scene).has_friction()) << "the first sphere has none";
}

TEST(ToolObstacles, HaveTheDampingAndTheViscosityOfTheirMaterials) {
  TouchScene scene = three_spheres();
  EXPECT_FALSE(make_tool_obstacles(scene).has_damping());
  scene.objects[1].material.damping_ns_per_m = 0.5;
  scene.objects[2].effects.viscosity.damping_ns_per_m = 1.5;
  const ToolObstacles obstacles = make_tool_obstacles(scene, 0);
  EXPECT_TRUE(obstacles.has_damping());
  EXPECT_FALSE(obstacles.leaves_out);
  ASSERT_EQ(obstacles.damping.size(), 2U);
  EXPECT_EQ(obstacles.damping[0].normal_ns_per_m, 0.5);
  EXPECT_EQ(obstacles.damping[0].along_ns_per_m, 0.0);
  EXPECT_EQ(obstacles.damping[1].normal_ns_per_m, 0.0);
  EXPECT_EQ(obstacles.damping[1].along_ns_per_m, 1.5);
}

TEST(ToolObstacles, SayThatAnotherEffectOfASurfaceIsLeftOut) {
  EXPECT_FALSE(make_tool_obstacles(three_spheres()).leaves_out);
  TouchScene one_sided = three_spheres();
  one_sided.objects[2].material.two_sided = false;
  EXPECT_TRUE(make_tool_obstacles(one_sided).leaves_out);
  TouchScene ringing = three_spheres();
  ringing.objects[1].effects.tap.ns_per_m = 1.0;
  EXPECT_TRUE(make_tool_obstacles(ringing).leaves_out);
  TouchScene with_spring = three_spheres();
  with_spring.effects.emplace_back(SpringEffect{.stiffness_n_per_m = 900.0});
  const ToolObstacles obstacles = make_tool_obstacles(with_spring);
  EXPECT_FALSE(obstacles.leaves_out) << "effects in free space act on a tool";
  EXPECT_EQ(obstacles.effects.size(), 1U);
  EXPECT_LT(obstacles.stiffness_n_per_m, 900.0) << "walls are as stiff as surfaces";
}

}  // namespace
}  // namespace hapton
