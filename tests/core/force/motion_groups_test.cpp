#include "core/force/motion_groups.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

std::shared_ptr<const KeyframeMotion> grouped_motion(double height_m) {
  return std::make_shared<const KeyframeMotion>(
      Vec3::Zero(), std::vector<Keyframe>{{0.0, Vec3::Zero(), Quat::Identity()}, {1.0, Vec3(0, 0, height_m), Quat::Identity()}}, false);
}

TouchScene boxes(int count) {
  TouchScene scene;
  for (int n = 0; n < count; ++n) scene.objects.push_back({made::shared(made::box(Vec3(n, 0, 0), Vec3(n + 0.5, 1, 1))), {}});
  return scene;
}

TEST(MotionGroups, WhatMovesAlikeIsTogetherAndWhatStandsStillIsFirst) {
  TouchScene scene = boxes(7);
  scene.objects[0].motion = grouped_motion(0.1);
  scene.objects[2].motion = grouped_motion(0.1);  // another object of the same motion
  scene.objects[3].motion = grouped_motion(0.2);
  scene.objects[4].command_pivot = Vec3::Zero();
  scene.objects[6].command_pivot = Vec3::Zero();
  const std::vector<MotionGroup> groups = group_by_motion(scene);
  ASSERT_EQ(groups.size(), 5U);
  EXPECT_FALSE(groups[0].moves());
  EXPECT_EQ(groups[0].objects, (std::vector{1, 5}));
  EXPECT_EQ(groups[1].objects, (std::vector{0, 2}));
  EXPECT_EQ(groups[2].objects, (std::vector{3}));
  EXPECT_EQ(groups[3].objects, (std::vector{4}));
  EXPECT_EQ(groups[3].commanded, 0);
  EXPECT_EQ(groups[4].objects, (std::vector{6}));
  EXPECT_EQ(groups[4].commanded, 1);
  EXPECT_TRUE(groups[4].is_alone());
}

TEST(MotionGroups, WhereEverythingMovesNothingStandsStill) {
  TouchScene scene = boxes(1);
  scene.objects[0].motion = grouped_motion(0.1);
  const std::vector<MotionGroup> groups = group_by_motion(scene);
  ASSERT_EQ(groups.size(), 1U);
  EXPECT_TRUE(groups[0].moves());
}

TEST(MotionGroups, SharedMaterialHasNeitherStaticFrictionNorDamping) {
  const Material shared = shared_material({700.0, 3.0, 0.5, 0.4, false});
  EXPECT_EQ(shared.stiffness_n_per_m, 700.0);
  EXPECT_EQ(shared.damping_ns_per_m, 0.0);
  EXPECT_EQ(shared.friction_static, 0.4);
  EXPECT_EQ(shared.friction_dynamic, 0.4);
  EXPECT_FALSE(shared.two_sided);
}

}  // namespace
}  // namespace hapton
