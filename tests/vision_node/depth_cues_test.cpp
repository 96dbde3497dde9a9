#include "vision_node/depth_cues.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(DepthCues, TheWorkspaceHasTwelveEdgesOfItsThreeLengths) {
  const auto edges = make_workspace_box();
  ASSERT_EQ(edges.size(), 12U);
  int edges_of_length[3] = {0, 0, 0};
  for (const auto& [from, to] : edges) {
    for (int k = 0; k < 3; ++k) edges_of_length[k] += std::abs((to - from).norm() - workspace_size_m()[k]) < 1e-12;
    EXPECT_TRUE(from.cwiseAbs().isApprox(0.5 * workspace_size_m()));
  }
  for (const int count : edges_of_length) EXPECT_EQ(count, 4);
}

TEST(DepthCues, TheNearestCornerIsTheOneOnTheViewersSide) {
  const Vec3 corner = find_nearest_corner(Vec3(-0.3, 0.2, 0.6));
  EXPECT_TRUE(corner.isApprox(0.5 * Vec3(-0.2667, 0.1905, 0.381)));
}

TEST(DepthCues, TheGridLiesOnTheFloorOfTheWorkspaceAndWithinIt) {
  const auto lines = make_ground_grid();
  EXPECT_GT(lines.size(), 20U);
  for (const auto& segment : lines) {
    for (const Vec3& p : segment) {
      EXPECT_EQ(p.y(), ground_height_m());
      EXPECT_TRUE((p.cwiseAbs().array() <= 0.5 * workspace_size_m().array() + 1e-12).all());
    }
  }
}

TEST(DepthCues, AShadowLiesOnTheGroundInTheDirectionOfTheLight) {
  const Vec3 p(0.02, 0.05, -0.03);
  const auto shadow = find_shadow(p);
  ASSERT_TRUE(shadow);
  EXPECT_NEAR(shadow->y(), ground_height_m(), 1e-12);
  EXPECT_LT((p - *shadow).normalized().cross(direction_to_shadow_light()).norm(), 1e-12);
  const Vec3 on_ground(0.02, ground_height_m(), -0.03);
  EXPECT_LT((*find_shadow(on_ground) - on_ground).norm(), 1e-12) << "what touches the ground touches its shadow";
  EXPECT_FALSE(find_shadow(Vec3(0.0, -1.0, 0.0)));
}

TEST(ScaleBar, HasARoundLengthAtTrueScale) {
  const Framing framing = frame_sphere(Vec3::Zero(), 0.12, 0.063);
  for (const double view_m : {1e-4, 0.05, 0.3, 0.9, 40.0}) {
    Framing seen = framing;
    seen.view_m = view_m;
    const PictureSize size{640, 480};
    const StereoScreen screen = compute_screen(seen, size);
    const ScaleBar bar = choose_scale_bar(screen, size);
    const double drawn_px = project_to_pixel(screen, Eye::centre, size, Vec3(bar.length_m, 0, 0)).x() - 320.0;
    EXPECT_NEAR(bar.pixels, drawn_px, 1e-6);
    EXPECT_LE(bar.pixels, 0.2 * 640);
    EXPECT_GT(bar.pixels, 0.07 * 640);
  }
  EXPECT_EQ(choose_scale_bar(compute_screen(framing, {640, 480}), {640, 480}).label, "50 mm");
}

}  // namespace
}  // namespace hapton
