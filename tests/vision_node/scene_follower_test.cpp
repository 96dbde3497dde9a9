#include "vision_node/scene_follower.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

Scene scene_with_hash(std::uint64_t given_hash) {
  Scene scene;
  scene.given_hash = given_hash;
  return scene;
}

TEST(SceneFollower, ASceneOfOtherMeshesWaitsUntilItIsFelt) {
  SceneFollower follower(1);
  follower.set_felt(1);
  EXPECT_FALSE(follower.take_due()) << "nothing was saved";
  follower.offer(scene_with_hash(2), 0);
  EXPECT_FALSE(follower.take_due());
  follower.set_felt(1);
  EXPECT_FALSE(follower.take_due());
  follower.set_felt(2);
  const auto due = follower.take_due();
  ASSERT_TRUE(due);
  EXPECT_EQ(due->given_hash, 2U);
  EXPECT_FALSE(follower.take_due());
}

TEST(SceneFollower, ColoursAndLightsDoNotWait) {
  SceneFollower follower(1);
  follower.set_felt(1);
  follower.offer(scene_with_hash(1), 0);
  EXPECT_TRUE(follower.take_due());
}

TEST(SceneFollower, WhatIsFeltMayBeUnknownOrAnotherScene) {
  SceneFollower unknown(1);
  unknown.offer(scene_with_hash(2), 0);
  EXPECT_TRUE(unknown.take_due()) << "no haptics node";
  SceneFollower other(1);
  other.set_felt(7);
  other.offer(scene_with_hash(2), 0);
  EXPECT_TRUE(other.take_due()) << "they differ anyway";
  other.set_felt(2);
  other.offer(scene_with_hash(3), 0);
  EXPECT_FALSE(other.take_due()) << "now they are the same";
}

TEST(SceneFollower, HapticsMayBeFirst) {
  SceneFollower follower(1);
  follower.set_felt(2);
  EXPECT_FALSE(follower.take_due());
  follower.offer(scene_with_hash(2), 0);
  EXPECT_TRUE(follower.take_due());
}

TEST(SceneFollower, TheNewestFileCountsAndItsOldContentIsShownAtOnce) {
  SceneFollower follower(1);
  follower.set_felt(1);
  follower.offer(scene_with_hash(2), 0);
  follower.offer(scene_with_hash(3), 0);
  follower.set_felt(2);
  const auto due = follower.take_due();
  ASSERT_TRUE(due) << "what is felt has left the scene shown";
  EXPECT_EQ(due->given_hash, 3U);
  follower.set_felt(3);
  follower.offer(scene_with_hash(4), 0);
  EXPECT_FALSE(follower.take_due());
  follower.offer(scene_with_hash(3), 0);
  EXPECT_TRUE(follower.take_due()) << "the change was taken back";
}

TEST(SceneFollower, TheWaitIsReportedOnce) {
  SceneFollower follower(1);
  follower.set_felt(1);
  EXPECT_FALSE(follower.take_overdue(SceneFollower::kReportAfterNs));
  follower.offer(scene_with_hash(2), 100);
  EXPECT_FALSE(follower.take_overdue(99 + SceneFollower::kReportAfterNs));
  EXPECT_TRUE(follower.take_overdue(100 + SceneFollower::kReportAfterNs));
  EXPECT_FALSE(follower.take_overdue(200 + SceneFollower::kReportAfterNs));
  EXPECT_TRUE(follower.is_overdue());
  follower.offer(scene_with_hash(3), 300 + SceneFollower::kReportAfterNs);
  EXPECT_FALSE(follower.is_overdue()) << "it has just come";
  EXPECT_TRUE(follower.take_overdue(300 + 2 * SceneFollower::kReportAfterNs));
  follower.set_felt(3);
  EXPECT_TRUE(follower.take_due());
  EXPECT_FALSE(follower.is_overdue());
}

}  // namespace
}  // namespace hapton
