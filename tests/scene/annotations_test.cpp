#include "scene/annotations.h"

#include <gtest/gtest.h>

#include <numbers>

namespace hapton {
namespace {

Pose annotation_pose(const Vec3& p, double angle) {
  Pose X = Pose::Identity();
  X.translation() = p;
  X.linear() = Eigen::AngleAxisd(angle, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  return X;
}

// The quaternion of a file may have few digits, so that its length is not exactly 1: the pose must be rigid nevertheless.
TEST(PutDowns, TheirPoseIsRigid) {
  PutDown put_down{.object = 1};
  put_down.p_m = Vec3(1, 2, 3);
  put_down.q = Quat(0.707, 0.0, 0.0, 0.707);
  EXPECT_LT((put_down.pose() * Vec3(1, 0, 0) - Vec3(1, 3, 3)).norm(), 1e-15);
  EXPECT_LT((put_down.pose().linear().transpose() * put_down.pose().linear() - Mat3::Identity()).norm(), 1e-15);
}

TEST(AnnotationLengths, AMeasureIsTheStraightLine) {
  const Measure measure{{{{0, {0.0, 0.0, 0.0}}, {0, {0.003, 0.004, 0.012}}}}};
  EXPECT_EQ(compute_length_m(measure, {}), Vec3(0.003, 0.004, 0.012).norm());
  EXPECT_DOUBLE_EQ(compute_length_m(measure, {}), 0.013);
}

TEST(AnnotationLengths, OnOneObjectItDoesNotChangeAsThatMoves) {
  const Measure measure{{{{1, {0.1, 0.2, 0.3}}, {1, {-0.3, 0.25, 0.1}}}}};
  const double before = compute_length_m(measure, {});
  EXPECT_EQ(compute_length_m(measure, {Pose::Identity(), annotation_pose({7, -3, 2}, 1.2)}), before);
}

TEST(AnnotationLengths, BetweenTwoObjectsItFollowsThem) {
  const Measure measure{{{{0, Vec3::Zero()}, {1, {0.0, 0.0, 0.1}}}}};
  EXPECT_DOUBLE_EQ(compute_length_m(measure, {}), 0.1);
  const ObjectPoses moved = {Pose::Identity(), annotation_pose({0.0, 0.0, 0.2}, 0.0)};
  EXPECT_DOUBLE_EQ(compute_length_m(measure, moved), 0.3);
  EXPECT_DOUBLE_EQ(compute_length_m(measure, {annotation_pose({0, 0, 0.2}, 0.0)}), 0.1) << "an object beyond the list is where it was";
}

TEST(AnnotationLengths, AStrokeIsAsLongAsItsPieces) {
  EXPECT_EQ(compute_length_m(Stroke{0, {}}), 0.0);
  EXPECT_EQ(compute_length_m(Stroke{0, {{1, 1, 1}}}), 0.0);
  EXPECT_DOUBLE_EQ(compute_length_m(Stroke{0, {{0, 0, 0}, {3, 4, 0}, {3, 4, 12}}}), 17.0);
}

TEST(AnnotationPoints, AreCounted) {
  Annotations annotations;
  EXPECT_EQ(count_points(annotations), 0U);
  annotations.entries = {Stroke{0, {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}}, Measure{}};
  EXPECT_EQ(count_points(annotations), 5U);
}

}  // namespace
}  // namespace hapton
