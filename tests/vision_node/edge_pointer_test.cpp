#include "vision_node/edge_pointer.h"

#include <limits>

#include <gtest/gtest.h>

namespace hapton {
namespace {

constexpr PictureSize kPointerWindow{640, 480};
const StereoScreen kScreen = compute_screen(frame_sphere(Vec3::Zero(), 0.05, 0.063), kPointerWindow);

TEST(EdgePointer, IsNotThereWhileThePointIsInThePicture) {
  EXPECT_FALSE(find_edge_pointer(kScreen, Eye::centre, kPointerWindow, Vec3::Zero()));
  EXPECT_FALSE(find_edge_pointer(kScreen, Eye::left, kPointerWindow, Vec3(0.02, 0.02, 0.02)));
}

TEST(EdgePointer, PointsToWhereThePointIsAndSaysHowFar) {
  const auto right = find_edge_pointer(kScreen, Eye::centre, kPointerWindow, Vec3(0.3, 0.0, 0.0));
  ASSERT_TRUE(right);
  EXPECT_LT((right->towards - Vec2(1.0, 0.0)).norm(), 1e-9);
  EXPECT_GT(right->at_px.x(), 580.0);
  EXPECT_LT(right->at_px.x(), 640.0);
  EXPECT_NEAR(right->at_px.y(), 240.0, 1e-6);
  EXPECT_EQ(right->label, "probe 300 mm");
  const auto below = find_edge_pointer(kScreen, Eye::centre, kPointerWindow, Vec3(0.1, -2.0, 0.0));
  ASSERT_TRUE(below);
  EXPECT_GT(below->at_px.y(), 0.0);
  EXPECT_LT(below->at_px.y(), 60.0);
  EXPECT_EQ(below->label, "probe 2.0 m");
}

TEST(EdgePointer, PointsToWhatIsBehindTheViewer) {
  const auto behind = find_edge_pointer(kScreen, Eye::centre, kPointerWindow, Vec3(-0.1, 0.0, 3.0));
  ASSERT_TRUE(behind);
  EXPECT_LT((behind->towards - Vec2(-1.0, 0.0)).norm(), 1e-9);
  EXPECT_LT(behind->at_px.x(), 60.0);
}

TEST(EdgePointer, APointThatIsNotFiniteIsNowhere) {
  EXPECT_FALSE(find_edge_pointer(kScreen, Eye::centre, kPointerWindow, Vec3::Constant(std::numeric_limits<double>::quiet_NaN())));
  EXPECT_FALSE(find_edge_pointer(kScreen, Eye::centre, {0, 0}, Vec3(1.0, 0.0, 0.0)));
}

}  // namespace
}  // namespace hapton
