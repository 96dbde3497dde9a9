#include "vision_node/scene_framing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string_view>
#include <utility>
#include <vector>

#include "tests/vision_node/made_views.h"
#include "vision_node/depth_cues.h"

namespace hapton {
namespace {

constexpr PictureSize kWindow{1280, 720};

Scene ball_at(const Vec3& p_SO, double radius_m) {
  Scene scene;
  scene.objects.push_back({"ball", make_marker(p_SO, radius_m), {}, {}});
  return scene;
}

VisionOptions window_options(PictureSize size = kWindow) {
  VisionOptions options;
  options.view.width_px = size.width_px;
  options.view.height_px = size.height_px;
  return options;
}

Vec2 pixel_of(const Framing& framing, const Vec3& p_W, PictureSize size = kWindow) {
  return project_to_pixel(compute_screen(framing, size), Eye::centre, size, p_W);
}

bool shows(const Framing& framing, const Vec3& p_W, PictureSize size = kWindow) {
  const Vec2 p = pixel_of(framing, p_W, size);
  return p.x() >= 0.0 && p.y() >= 0.0 && p.x() <= size.width_px && p.y() <= size.height_px;
}

bool shows_workspace(const Framing& framing, PictureSize size = kWindow) {
  for (const auto& edge : make_workspace_box()) {
    if (!shows(framing, edge[0], size) || !shows(framing, edge[1], size)) return false;
  }
  return true;
}

// The drawn width of a ball, as a share of the picture's smaller side.
double width_of_ball(const Framing& framing, const Vec3& p_W, double radius_m) {
  const Vec3 to_the_right = compute_screen(framing, kWindow).X_WV.linear().col(0) * radius_m;
  return (pixel_of(framing, p_W + to_the_right) - pixel_of(framing, p_W - to_the_right)).norm() / kWindow.height_px;
}

TEST(SceneFraming, ShowsTheSceneAndTheWholeWorkspace) {
  for (const double radius_m : {0.02, 0.05, 0.1, 0.14}) {
    for (const PictureSize size : {kWindow, PictureSize{640, 720}, PictureSize{400, 900}}) {
      const Framing framing = frame_scene(ball_at(Vec3::Zero(), radius_m), window_options(size));
      EXPECT_TRUE(shows_workspace(framing, size)) << radius_m << " m in " << size.width_px << "x" << size.height_px;
    }
  }
}

TEST(SceneFraming, HasTheWorkspaceInTheMiddleAndTheSceneInWhateverTheDialsDo) {
  const Framing framing = frame_scene(ball_at({0.03, 0.0, 0.0}, 0.05), window_options());
  Vec2 low(kWindow.width_px, kWindow.height_px);
  Vec2 high = Vec2::Zero();
  for (const auto& edge : make_workspace_box()) {
    low = low.cwiseMin(pixel_of(framing, edge[0]));
    high = high.cwiseMax(pixel_of(framing, edge[0]));
    low = low.cwiseMin(pixel_of(framing, edge[1]));
    high = high.cwiseMax(pixel_of(framing, edge[1]));
  }
  EXPECT_NEAR(low.y(), kWindow.height_px - high.y(), 3.0);
  EXPECT_NEAR(low.x(), kWindow.width_px - high.x(), 3.0);
  for (double angle = 0.0; angle < 6.3; angle += 0.1) {
    for (const Vec3& axis : {Vec3(0.0, 1.0, 0.0), Vec3(0.6, 0.0, 0.8)}) {
      EXPECT_TRUE(shows(framing, Eigen::AngleAxisd(angle, axis) * Vec3(0.08, 0.0, 0.0)));
    }
  }
}

TEST(SceneFraming, ShowsTheWorkspaceToBothEyes) {
  VisionOptions options = window_options();
  options.view.stereo = StereoMode::side_by_side;
  const Framing framing = frame_scene(ball_at(Vec3::Zero(), 0.05), options);
  const PictureSize half{640, 720};
  for (const Eye eye : {Eye::left, Eye::right}) {
    for (const auto& edge : make_workspace_box()) {
      const Vec2 p = project_to_pixel(compute_screen(framing, half), eye, half, edge[0]);
      EXPECT_TRUE(p.x() >= 0.0 && p.y() >= 0.0 && p.x() <= 640.0 && p.y() <= 720.0);
    }
  }
}

TEST(SceneFraming, LeavesNoMoreRoomThanTheWorkspaceNeeds) {
  const Framing framing = frame_scene(ball_at(Vec3::Zero(), 0.05), window_options());
  Framing nearer = framing;
  nearer.view_m *= 0.93;
  EXPECT_FALSE(shows_workspace(nearer));
}

TEST(SceneFraming, GrowsWithASceneThatIsLargerThanTheWorkspace) {
  const Framing framing = frame_scene(ball_at(Vec3::Zero(), 2.0), window_options());
  const double width = width_of_ball(framing, Vec3::Zero(), 2.0);
  EXPECT_GT(width, 0.8);
  EXPECT_LE(width, 1.0);
  EXPECT_TRUE(shows_workspace(framing));
}

TEST(SceneFraming, ASpeckFillsThePictureWhereverItIs) {
  for (const Vec3& p_W : {Vec3(0.0, 0.0, 0.0), Vec3(0.03, -0.02, 0.05), Vec3(0.0, 0.09, 0.0)}) {
    const Framing framing = frame_scene(ball_at(p_W, 0.00005), window_options());
    EXPECT_LT((pixel_of(framing, p_W) - Vec2(640.0, 360.0)).norm(), 1.0);
    EXPECT_GT(width_of_ball(framing, p_W, 0.00005), 0.5);
  }
}

TEST(SceneFraming, ASceneThatLiesApartIsShownWithTheWorkspace) {
  const Vec3 p_W(1.2, 0.3, -0.4);
  const Framing framing = frame_scene(ball_at(p_W, 0.3), window_options());
  EXPECT_TRUE(shows_workspace(framing));
  EXPECT_TRUE(shows(framing, p_W));
  EXPECT_GT(width_of_ball(framing, p_W, 0.3), 0.2) << "not lost in a picture of the way there";
}

// On the line through both centres, the two extend from their outermost point on one side to that on the other side.
TEST(SceneFraming, TheMiddleIsThatOfTheSceneAndTheWorkspaceTogether) {
  const double workspace_m = 0.5 * workspace_size_m().norm();
  for (const auto& [p_WO, radius_m] :
       {std::pair(Vec3(1.2, 0.3, -0.4), 0.3), std::pair(Vec3(-0.3, 0.0, 0.0), 0.1), std::pair(Vec3(0, 3, 0), 1.4)}) {
    const Framing framing = frame_scene(ball_at(p_WO, radius_m), window_options());
    const double radius = bound_scene(ball_at(p_WO, radius_m)).radius_m;
    const double from_m = std::min(-workspace_m, p_WO.norm() - radius);
    const double to_m = std::max(workspace_m, p_WO.norm() + radius);
    EXPECT_LT((framing.p_WC - 0.5 * (from_m + to_m) * p_WO.normalized()).norm(), 1e-6) << p_WO.transpose();
    EXPECT_TRUE(shows(framing, -workspace_m * p_WO.normalized())) << p_WO.transpose();
    EXPECT_TRUE(shows(framing, p_WO + radius_m * p_WO.normalized())) << p_WO.transpose();
  }
  // A scene does not lie apart if its centre is less than two of its radii away, or within the radius of the workspace.
  for (const auto& [x_m, radius_m] : {std::pair(0.59, 0.3), std::pair(0.24, 0.01)}) {
    EXPECT_EQ(frame_scene(ball_at({x_m, 0, 0}, radius_m), window_options()).p_WC, Vec3::Zero()) << x_m;
  }
}

TEST(SceneFraming, ASceneInAnotherPlaceAltogetherIsShownAlone) {
  const Vec3 p_W(4.5e5, 12.0, 5.4e6);
  const Framing framing = frame_scene(ball_at(p_W, 30.0), window_options());
  EXPECT_LT((pixel_of(framing, p_W) - Vec2(640.0, 360.0)).norm(), 1.0);
  EXPECT_GT(width_of_ball(framing, p_W, 30.0), 0.7);
}

TEST(SceneFraming, GoesByTheDialsAtTheStart) {
  VisionOptions options = window_options();
  options.dials_degrees = Vec3(0.0, 90.0, 0.0);
  const Framing framing = frame_scene(ball_at({0.08, 0.0, 0.0}, 0.0001), options);
  Dials dials;
  dials.turn(1, 90.0);
  EXPECT_LT((pixel_of(framing, dials.compute_pose(Vec3::Zero()) * Vec3(0.08, 0.0, 0.0)) - Vec2(640.0, 360.0)).norm(), 1.0);
}

TEST(SceneFraming, UsesTheSizeOfTheOptions) {
  VisionOptions options = window_options();
  options.view_mm = 50.0;
  EXPECT_EQ(frame_scene(ball_at(Vec3::Zero(), 0.05), options).view_m, 0.05);
}

Scene scene_with_camera(const SceneCamera& camera) {
  Scene scene = ball_at(Vec3::Zero(), 0.05);
  scene.view.camera = camera;
  return scene;
}

// Checks where the point between the eyes is, and what is seen in the middle of the picture and at the middle of its upper edge.
void expect_camera(const Framing& framing, const SceneCamera& camera, double tolerance) {
  EXPECT_LT((compute_eye_position(compute_screen(framing, kWindow), Eye::centre) - camera.p_WE).norm(), tolerance);
  EXPECT_LT((pixel_of(framing, camera.p_WC) - Vec2(640.0, 360.0)).norm(), 1e-6);
  const Vec3 back = camera.p_WE - camera.p_WC;
  const Vec3 up = (camera.up - camera.up.dot(back) / back.squaredNorm() * back).normalized();
  const double half_m = back.norm() * std::tan(0.5 * camera.view_angle_deg * std::numbers::pi / 180.0);
  EXPECT_LT((pixel_of(framing, camera.p_WC + half_m * up) - Vec2(640.0, 720.0)).norm(), 720.0 * tolerance);
}

TEST(SceneFraming, TheScenesCameraSeesWhatItSays) {
  for (const SceneCamera& camera : {SceneCamera{.p_WE = {0.3, 0.5, 0.6}, .p_WC = {0.0, 0.1, 0.0}},
                                    {.p_WE = {-0.2, -0.4, -0.5}, .p_WC = {0.1, 0.0, 0.02}, .view_angle_deg = 60.0},
                                    {.p_WE = {0.0, 0.1, 0.9}, .up = Vec3(1.0, 1.0, 0.0).normalized()},
                                    {.p_WE = {3.0, 4.0, 5.0}, .up = -Vec3::UnitZ(), .view_angle_deg = 5.0}}) {
    const Framing framing = frame_scene(scene_with_camera(camera), window_options());
    expect_camera(framing, camera, 1e-9);
    EXPECT_NEAR(framing.ipd_m / framing.distance_m, 0.063 / kDeskDistance, 1e-12) << "depth looks as at a desk";
    const StereoScreen screen = compute_screen(framing, kWindow);
    EXPECT_GT(screen.far_m, camera.p_WE.norm() + 0.05);
    EXPECT_LT(screen.near_m, camera.p_WE.norm() - 0.05);
  }
}

// At 90 degrees `up` would be undefined, so pitch ends at 89 degrees: the camera may be off by that degree.
TEST(SceneFraming, TheScenesCameraMayLookStraightDownOrUp) {
  for (const double height_m : {0.7, -0.7}) {
    for (const Vec3& up : {Vec3(0, 0, -1), Vec3(1, 0, 0), Vec3(-0.6, 0, 0.8)}) {
      const SceneCamera camera{.p_WE = {0.0, height_m, 0.0}, .up = up};
      expect_camera(frame_scene(scene_with_camera(camera), window_options()), camera, 0.02);
    }
  }
}

TEST(SceneFraming, FlagsCountMoreThanTheScenesCamera) {
  const SceneCamera camera{.p_WE = {0.3, 0.5, 0.6}, .p_WC = {0.0, 0.1, 0.0}};
  const Framing without_flags = frame_scene(scene_with_camera(camera), window_options());
  VisionOptions options = window_options();
  options.view_yaw_deg = 10.0;
  options.is_view_yaw_given = true;
  EXPECT_NEAR(frame_scene(scene_with_camera(camera), options).yaw_rad, 10.0 * std::numbers::pi / 180.0, 1e-12);
  EXPECT_EQ(frame_scene(scene_with_camera(camera), options).pitch_rad, without_flags.pitch_rad);
  options.view_pitch_deg = 5.0;
  options.is_view_pitch_given = true;
  EXPECT_NEAR(frame_scene(scene_with_camera(camera), options).pitch_rad, 5.0 * std::numbers::pi / 180.0, 1e-12);
  options.view_mm = 50.0;
  EXPECT_EQ(frame_scene(scene_with_camera(camera), options).view_m, 0.05);
  EXPECT_EQ(frame_scene(scene_with_camera(camera), options).p_WC, camera.p_WC);
}

// Each of these options decides where the eyes are.
TEST(SceneFraming, TheScenesCameraGivesWayToAHeadAndAScreen) {
  const Scene scene = scene_with_camera({.p_WE = {3.0, 4.0, 5.0}});
  std::vector<std::pair<std::string_view, VisionOptions>> cases(4, {"", window_options()});
  cases[0].first = "--screen";
  cases[0].second.screen = ScreenRectangle{Pose::Identity(), 0.32, 0.24};
  cases[1].first = "--screen-width-mm";
  cases[1].second.screen_width_mm = 520.0;
  cases[2].first = "--stereo openxr";
  cases[2].second.view.stereo = StereoMode::openxr;
  cases[3].first = "--head";
  cases[3].second.has_space_head = true;
  for (const auto& [flag, options] : cases) {
    EXPECT_EQ(find_view_flag(options), flag);
    const Framing without = frame_scene(ball_at(Vec3::Zero(), 0.05), options);
    const Framing with = frame_scene(scene, options);
    EXPECT_EQ(compute_screen(with, kWindow).X_WV.matrix(), compute_screen(without, kWindow).X_WV.matrix()) << flag;
    EXPECT_EQ(with.distance_m, without.distance_m) << flag;
  }
  EXPECT_EQ(find_view_flag(window_options()), "");
}

TEST(SceneSphere, IsRoundTheMiddleOfTheBox) {
  Scene scene = ball_at({0.1, 0.0, 0.0}, 0.02);
  scene.objects.push_back({"ball", make_marker({-0.1, 0.0, 0.0}, 0.02), {}, {}});
  const SceneSphere sphere = bound_scene(scene);
  EXPECT_LT(sphere.p_SO.norm(), 1e-12);
  EXPECT_NEAR(sphere.radius_m, 0.12, 1e-6);
  EXPECT_EQ(bound_scene({}).radius_m, 0.0);
}

}  // namespace
}  // namespace hapton
