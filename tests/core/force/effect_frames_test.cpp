#include "core/force/effect_frames.h"

#include <gtest/gtest.h>

#include "core/effects/effect_step.h"
#include "tests/core/force/moving_plates.h"
#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

const SurfaceEffects kViscous = {.viscosity = {.damping_ns_per_m = 4.0}};

TEST(EffectFrames, AreOfObjectsWithEffectsThatMove) {
  const auto motion = shift_motion(Vec3::Zero(), {0.1, 0.0, 0.0}, 1.0);
  TouchScene scene;
  for (int i = 0; i < 5; ++i) scene.objects.push_back(plate_object(Vec3::Zero(), Vec3::Ones()));
  EXPECT_TRUE(EffectFrames(scene).of_objects().empty());
  scene.objects[1].motion = motion;
  scene.objects[2].motion = motion;
  scene.objects[4].command_pivot = Vec3::Zero();
  EXPECT_TRUE(EffectFrames(scene).of_objects().empty()) << "no effects";
  scene.objects[0].effects = kViscous;
  EXPECT_TRUE(EffectFrames(scene).of_objects().empty()) << "it stands still";
  scene.objects[2].effects = kViscous;
  EXPECT_EQ(EffectFrames(scene).of_objects(), (std::vector<int>{-1, 0, 0, -1, -1})) << "objects 1 and 2 move together";
  scene.objects[4].effects = kViscous;
  EXPECT_EQ(EffectFrames(scene).of_objects(), (std::vector<int>{-1, 0, 0, -1, 1}));
  scene.objects[3].stream_reach_m = 0.01;
  scene.objects[3].effects = kViscous;
  EXPECT_EQ(EffectFrames(scene).of_objects(), (std::vector<int>{-1, 0, 0, 1, 2}));
}

TEST(EffectFrames, AreWhereTheObjectsAre) {
  TouchScene scene;
  scene.objects.push_back(plate_object(Vec3::Zero(), Vec3::Ones(), shift_motion(Vec3::Zero(), {0.1, 0.0, 0.0}, 1.0)));
  scene.objects.push_back(plate_object(Vec3::Zero(), Vec3::Ones()));
  scene.objects[1].command_pivot = Vec3::Zero();
  for (TouchObject& object : scene.objects) object.effects = kViscous;
  EffectFrames frames(scene);
  Pose commanded = Pose::Identity();
  commanded.translation() = Vec3(0, 0, 0.3);
  const AllocationGuard guard;
  const auto X_SF = frames.place({.time_s = 0.5, .commanded = {&commanded, 1}});
  EXPECT_TRUE(!AllocationGuard::is_available() || guard.count() == 0U);
  ASSERT_EQ(X_SF.size(), 2U);
  EXPECT_LT((X_SF[0].translation() - Vec3(0.05, 0, 0)).norm(), 1e-15);
  EXPECT_EQ(X_SF[1].translation(), commanded.translation());
  EXPECT_LT((frames.at_rest(0, {0.06, 0.2, 0.0}) - Vec3(0.01, 0.2, 0.0)).norm(), 1e-15);
  EXPECT_EQ(frames.place({.time_s = 0.0})[1].translation(), Vec3(Vec3::Zero())) << "at rest";
}

}  // namespace
}  // namespace hapton
