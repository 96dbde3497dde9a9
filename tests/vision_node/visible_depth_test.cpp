#include "vision_node/visible_depth.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/vision_node/made_surface.h"

namespace hapton {
namespace {

constexpr PictureSize kSeenPicture{320, 240};
constexpr double kNoSurface = std::numeric_limits<double>::infinity();

TEST(VisibleDepth, KnowsHowFarTheSurfaceIsAndWhereItLies) {
  Framing framing = frame_sphere({0.01, 0.02, -0.03}, 0.1, 0.063);
  framing.yaw_rad = 0.4;
  framing.pitch_rad = 0.3;
  const StereoScreen screen = compute_screen(framing, kSeenPicture);
  const VisibleDepth seen =
      make_visible_depth(screen, kSeenPicture, [&](double x, double) { return x < 160.0 ? screen.distance_m - 0.05 : kNoSurface; });
  EXPECT_NEAR(seen.depth_m({80.5, 100.5}), screen.distance_m - 0.05, 1e-6);
  EXPECT_EQ(seen.depth_m({200.0, 100.0}), kNoSurface);
  EXPECT_EQ(seen.depth_m({-1.0, 100.0}), kNoSurface);
  EXPECT_EQ(seen.depth_m({80.0, 240.0}), kNoSurface);
  EXPECT_FALSE(seen.find({200.0, 100.0}));
  const auto p_WQ = seen.find({80.5, 100.5});
  ASSERT_TRUE(p_WQ);
  EXPECT_LT((seen.pixel_of(*p_WQ) - Vec2(80.5, 100.5)).norm(), 1e-6);
  EXPECT_NEAR(seen.depth_of(*p_WQ), screen.distance_m - 0.05, 1e-6);
}

}  // namespace
}  // namespace hapton
