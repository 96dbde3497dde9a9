#include "core/math/rigid_pose.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace hapton {
namespace {

std::array<float, 12> numbers_of(const Mat3& rotation, const Vec3& translation) {
  std::array<float, 12> numbers = {};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      numbers[static_cast<std::size_t>(4 * row + column)] = static_cast<float>(rotation(row, column));
    }
    numbers[static_cast<std::size_t>(4 * row + 3)] = static_cast<float>(translation[row]);
  }
  return numbers;
}

const Mat3 kTurned = Eigen::AngleAxisd(0.7, Vec3(1, 2, -2).normalized()).toRotationMatrix();

TEST(RigidPose, APointInItsFrameIsThatPointAgain) {
  Pose pose = Pose::Identity();
  pose.linear() = kTurned;
  pose.translation() = Vec3(0.5, -0.25, 2);
  const Vec3 point(0.1, 0.2, -0.3);
  EXPECT_NEAR((to_frame(pose, pose * point) - point).norm(), 0.0, 1e-15);
  EXPECT_EQ(to_frame(Pose::Identity(), point), point);
}

TEST(RigidPose, TakesRotationAndTranslation) {
  const auto pose = find_rigid_pose(numbers_of(kTurned, {0.5, -0.25, 2}));
  ASSERT_TRUE(pose);
  EXPECT_NEAR((pose->linear() - kTurned).norm(), 0.0, 1e-6);
  EXPECT_EQ(pose->translation(), Vec3(0.5, -0.25, 2));
}

TEST(RigidPose, MakesTheRotationExact) {
  const auto pose = find_rigid_pose(numbers_of((1.0 + 3e-5) * kTurned, Vec3::Zero()));
  ASSERT_TRUE(pose);
  EXPECT_NEAR((pose->linear().transpose() * pose->linear() - Mat3::Identity()).norm(), 0.0, 1e-14);
}

TEST(RigidPose, RejectsAnythingElse) {
  Mat3 shear = kTurned;
  shear.col(0) += 0.01 * shear.col(1);
  Mat3 mirror = kTurned;
  mirror.col(2) *= -1.0;
  for (const Mat3& wrong : {Mat3(1.01 * kTurned), shear, mirror, Mat3(Mat3::Zero()), Mat3(Mat3::Ones())}) {
    EXPECT_FALSE(find_rigid_pose(numbers_of(wrong, Vec3::Zero()))) << wrong;
  }
  for (std::size_t i = 0; i < 12; ++i) {
    auto numbers = numbers_of(kTurned, Vec3::Ones());
    numbers[i] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_FALSE(find_rigid_pose(numbers)) << i;
    numbers[i] = std::numeric_limits<float>::infinity();
    EXPECT_FALSE(find_rigid_pose(numbers)) << i;
  }
}

TEST(RigidPose, BothFunctionsHaveOneTolerance) {
  // For a scaled rotation, R R^T differs from the identity by 3 (s^2 - 1), summed over the diagonal; elsewhere it does not differ.
  for (const double part : {0.0, 0.5, 0.99, 1.01, 2.0}) {
    const double scale = std::sqrt(1.0 + part * kRigidTolerance / 3.0);
    const auto numbers = numbers_of(scale * Mat3::Identity(), Vec3::Zero());
    EXPECT_EQ(is_rigid(numbers), part < 1.0) << part;
    EXPECT_EQ(find_rigid_pose(numbers).has_value(), part < 1.0) << part;
  }
}

TEST(RigidPose, RejectsATranslationBeyondTheLimit) {
  EXPECT_TRUE(is_rigid(numbers_of(kTurned, {0, -kMaxTranslationM, 0})));
  EXPECT_FALSE(is_rigid(numbers_of(kTurned, {0, -1.001 * kMaxTranslationM, 0})));
}

}  // namespace
}  // namespace hapton
