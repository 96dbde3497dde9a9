#include "io_node/scene_reach.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

DeviceLimits limits_of_20_cm() {
  DeviceLimits limits;
  limits.workspace_min_m = Vec3(-0.1, -0.1, -0.1);
  limits.workspace_max_m = Vec3(0.1, 0.1, 0.1);
  return limits;
}

SceneFacts box_at(float x, float half) {
  SceneFacts facts{.given_hash = 1, .lowest_m = {x - half, -half, -half}, .highest_m = {x + half, half, half}, .point_count = 2};
  facts.points_m[0] = {x - half, 0, 0};
  facts.points_m[1] = {x + half, 0, 0};
  return facts;
}

SceneReach reach_of(const SceneFacts& facts, const Pose& X_WS = Pose::Identity()) { return find_reach(facts, X_WS, limits_of_20_cm()); }

TEST(SceneReach, IsJudgedByTheSurface) {
  EXPECT_EQ(reach_of(box_at(0, 0.05F)), SceneReach::in_reach);
  EXPECT_EQ(reach_of(box_at(0.14F, 0.05F)), SceneReach::in_reach);
  EXPECT_EQ(reach_of(box_at(0.3F, 0.05F)), SceneReach::out_of_reach);
  EXPECT_EQ(reach_of(box_at(-0.3F, 0.05F)), SceneReach::out_of_reach);
  EXPECT_EQ(reach_of(box_at(-0.14F, 0.05F), Pose(Eigen::AngleAxisd(M_PI, Vec3::UnitZ()))), SceneReach::in_reach);
  EXPECT_EQ(reach_of(box_at(0.3F, 0.05F), Pose(Eigen::Translation3d(-0.3, 0, 0))), SceneReach::in_reach);
  EXPECT_EQ(reach_of(box_at(0.3F, 0.05F), Pose(Eigen::AngleAxisd(1.0, Vec3::UnitZ()))), SceneReach::out_of_reach);
}

TEST(SceneReach, ASpeckIsTooSmall) {
  EXPECT_EQ(reach_of(box_at(0, 1e-4F)), SceneReach::too_small);
  EXPECT_EQ(reach_of(box_at(0, 0.00199F)), SceneReach::too_small);
  EXPECT_EQ(reach_of(box_at(0, 0.00201F)), SceneReach::in_reach);
}

TEST(SceneReach, SaysNothingOfWhatItCannotKnow) {
  // The workspace is a small part in the middle of this box: the few points of a scene (16 at most) tell little of the surface in it.
  EXPECT_EQ(reach_of(box_at(0, 50.0F)), SceneReach::unknown);
  EXPECT_EQ(reach_of(SceneFacts{}), SceneReach::unknown);
  EXPECT_EQ(find_reach(box_at(0, 0.05F), Pose::Identity(), {}), SceneReach::unknown);
}

TEST(SceneReach, APointMovesWithTheView) {
  const ViewTransform view{.revision = 1, .X_WS = {0, -1, 0, 1, 1, 0, 0, 2, 0, 0, 1, 3}};
  EXPECT_LT((point_in_world(box_at(1, 0.5F), pose_of(view), 1) - Vec3(1, 3.5, 3)).norm(), 1e-6);
}

}  // namespace
}  // namespace hapton
