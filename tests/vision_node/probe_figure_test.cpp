#include "vision_node/probe_figure.h"

#include <gtest/gtest.h>

#include "tests/vision_node/made_views.h"
#include "vision_node/depth_cues.h"

namespace hapton {
namespace {

constexpr PictureSize kEyePicture{640, 720};

bool is_tip(const std::uint8_t* rgb) { return rgb[0] > 90 && rgb[2] * 3 < rgb[0] && rgb[1] * 2 > rgb[0]; }
bool is_arrow(const std::uint8_t* rgb) { return rgb[1] > 90 && rgb[0] * 2 < rgb[1] && rgb[2] < rgb[1]; }

bool is_stylus(const std::uint8_t* rgb) { return rgb[0] > 120 && rgb[1] > 120 && rgb[2] > 120; }
// Includes the dark side of the ball, where no light falls.
bool is_ball(const std::uint8_t* rgb) { return rgb[0] > 50 && rgb[2] * 3 < rgb[0] && rgb[1] * 2 > rgb[0]; }
bool is_red(const std::uint8_t* rgb) { return rgb[0] > 120 && rgb[1] * 2 < rgb[0] && rgb[2] * 2 < rgb[0]; }
bool is_blue(const std::uint8_t* rgb) { return rgb[2] > 120 && rgb[0] * 2 < rgb[2]; }

struct Extent {
  int count = 0;
  int min_x = 1 << 20;
  int min_y = 1 << 20;
};

Extent find_extent(const Picture& picture, bool (*is_wanted)(const std::uint8_t*), int from, int to) {
  Extent extent;
  for (int y = 0; y < picture.size.height_px; ++y) {
    for (int x = from; x < to; ++x) {
      if (!is_wanted(picture.at(x, y))) continue;
      ++extent.count;
      extent.min_x = std::min(extent.min_x, x - from);
      extent.min_y = std::min(extent.min_y, y);
    }
  }
  return extent;
}

ProbeState state_at(const Vec3& p_WD, const Vec3& offset) {
  ProbeState state;
  state.p_WD = p_WD;
  state.visual_offset_m = offset;
  return state;
}

TEST(ProbeFigure, NothingIsDrawnBeforeItIsSet) {
  auto view = open_or_fail(plain_settings(StereoMode::side_by_side, 1280, 720), {});
  ASSERT_TRUE(view);
  view->draw();
  EXPECT_EQ(find_extent(view->read_picture(), is_tip, 0, 1280).count, 0);
}

// The stylus leans up and to the right, so the left and lower edges of the ball at its tip are always seen: a radius from its centre.
TEST(ProbeFigure, TipIsDrawnAtDevicePositionPlusVisualOffsetInBothEyes) {
  auto view = open_or_fail(plain_settings(StereoMode::side_by_side, 1280, 720), {});
  ASSERT_TRUE(view);
  const StereoScreen screen = view->screen();
  for (const Vec3& p_WD : {Vec3(0, 0, 0), Vec3(-0.05, 0.03, 0.07), Vec3(0.04, -0.06, -0.08)}) {
    const Vec3 offset(0.004, 0.011, -0.006);
    view->set_probe(make_shown_probe(state_at(p_WD, offset), make_lean(1.2)));
    view->draw();
    const Picture picture = view->read_picture();
    for (const auto& [eye, from] : {std::pair(Eye::left, 0), std::pair(Eye::right, 640)}) {
      const Vec2 centre = project_to_pixel(screen, eye, kEyePicture, p_WD + offset);
      const double stretch = screen.distance_m / (screen.distance_m - (p_WD + offset).z());
      const double radius_px = view->probe_sizes().tip_radius_m * stretch * 640 / screen.width_m;
      const Extent tip = find_extent(picture, is_tip, from, from + 640);
      ASSERT_GT(tip.count, 10);
      EXPECT_NEAR(tip.min_x, centre.x() - radius_px, 1.5);
      EXPECT_NEAR(tip.min_y, centre.y() - radius_px, 1.5);
    }
  }
}

TEST(ProbeFigure, OffsetAndPositionAddUp) {
  auto view = open_or_fail(plain_settings(StereoMode::side_by_side, 640, 360), {});
  ASSERT_TRUE(view);
  view->set_probe(make_shown_probe(state_at({0.01, 0.02, 0.03}, {0.01, -0.02, 0.005})));
  view->draw();
  const Picture offset = view->read_picture();
  view->set_probe(make_shown_probe(state_at({0.02, 0.0, 0.035}, Vec3::Zero())));
  view->draw();
  EXPECT_EQ(offset.rgb, view->read_picture().rgb);
}

TEST(ProbeFigure, ArrowIsSeenWhateverItsDirectionAndGrowsWithForce) {
  auto view = open_or_fail(plain_settings(StereoMode::side_by_side, 1280, 720), {});
  ASSERT_TRUE(view);
  ProbeShown probe;
  probe.q_WT = make_lean(0.9);
  view->set_probe(probe);
  view->draw();
  EXPECT_EQ(find_extent(view->read_picture(), is_arrow, 0, 640).count, 0);
  for (const Vec3& direction : {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 1, 0), Vec3(0, -1, 0), Vec3(0, 0, 1), Vec3(0, 0, -1)}) {
    int previous_count = 0;
    for (const double newtons : {0.5, 2.0}) {
      probe.force_n = newtons * direction;
      view->set_probe(probe);
      view->draw();
      const int count = find_extent(view->read_picture(), is_arrow, 0, 640).count;
      EXPECT_GT(count, 10) << direction.transpose() << " " << newtons << " N";
      if (direction.z() == 0.0) {
        EXPECT_GT(count, previous_count);
      }
      previous_count = count;
    }
  }
}

TEST(ProbeFigure, ArrowIsSeenThroughTheObjectItPointsInto) {
  auto wall = std::make_shared<TriangleMesh>();
  wall->vertices = {{-1, -1, 0.09}, {1, -1, 0.09}, {0, 1, 0.09}};
  wall->triangles = {{0, 1, 2}};
  auto view = open_or_fail(plain_settings(StereoMode::side_by_side, 1280, 720), {{wall, {0.5, 0.1, 0.1}}});
  ASSERT_TRUE(view);
  ProbeShown probe;
  probe.q_WT = make_lean(0.9);
  probe.force_n = {1.5, 0.5, -1.0};
  view->set_probe(probe);
  view->draw();
  const Picture picture = view->read_picture();
  EXPECT_GT(find_extent(picture, is_arrow, 0, 640).count, 100);
  EXPECT_GT(find_extent(picture, is_arrow, 640, 1280).count, 100);
  EXPECT_EQ(find_extent(picture, is_stylus, 0, 1280).count, 0) << "the wall hides the stylus";
  const int tip_through_wall = find_extent(picture, is_tip, 0, 1280).count;
  EXPECT_GT(tip_through_wall, 10) << "the tip shows through, dotted";
  wall->vertices[0].z() = wall->vertices[1].z() = wall->vertices[2].z() = -0.15;
  auto open_view = open_or_fail(plain_settings(StereoMode::side_by_side, 1280, 720), {{wall, {0.5, 0.1, 0.1}}});
  ASSERT_TRUE(open_view);
  open_view->set_probe(probe);
  open_view->draw();
  EXPECT_LT(tip_through_wall, 0.7 * find_extent(open_view->read_picture(), is_tip, 0, 1280).count);
  EXPECT_GT(find_extent(open_view->read_picture(), is_stylus, 0, 1280).count, 500);
}

TEST(ProbeFigure, TheTipIsSeenThoughTheForcePointsAtTheViewer) {
  auto view = open_or_fail(plain_settings(StereoMode::mono, 720, 720), {});
  ASSERT_TRUE(view);
  ProbeShown probe;
  probe.q_WT = make_lean(0.9);
  view->set_probe(probe);
  view->draw();
  const int alone = find_extent(view->read_picture(), is_tip, 0, 720).count;
  probe.force_n = {0.0, 0.0, 2.0};
  view->set_probe(probe);
  view->draw();
  EXPECT_GT(find_extent(view->read_picture(), is_tip, 0, 720).count, 0.3 * alone);
}

TEST(ProbeFigure, ASphereIsDrawnAtItsHapticSize) {
  auto view = open_or_fail(plain_settings(StereoMode::mono, 720, 720), {});
  ASSERT_TRUE(view);
  ProbeShown probe;
  probe.q_WT = make_lean(1.2);
  const StereoScreen screen = view->screen();
  const Vec2 centre = project_to_pixel(screen, Eye::centre, {720, 720}, Vec3::Zero());
  for (const double radius_m : {0.015, 0.005}) {
    view->set_probe_radius(radius_m);
    view->set_probe(probe);
    view->draw();
    const Extent tip = find_extent(view->read_picture(), is_ball, 0, 720);
    EXPECT_NEAR(centre.x() - tip.min_x, radius_m * 720 / screen.width_m, 1.5);
    EXPECT_NEAR(centre.y() - tip.min_y, radius_m * 720 / screen.width_m, 1.5);
  }
  view->set_probe_radius(0.0);
  view->set_probe(probe);
  view->draw();
  EXPECT_NEAR(centre.x() - find_extent(view->read_picture(), is_ball, 0, 720).min_x,
              view->probe_sizes().tip_radius_m * 720 / screen.width_m, 1.5);
}

TEST(ProbeFigure, AForceBeyondTheArrowsLengthIsMarkedRed) {
  auto view = open_or_fail(plain_settings(StereoMode::mono, 720, 720), {});
  ASSERT_TRUE(view);
  ProbeShown probe;
  probe.q_WT = make_lean(0.9);
  const ProbeSizes sizes = view->probe_sizes();
  const double longest_arrow_n = sizes.arrow_max_m / sizes.arrow_m_per_n;
  for (const auto& [newtons, is_marked] : {std::pair(0.9 * longest_arrow_n, false), std::pair(1.1 * longest_arrow_n, true)}) {
    probe.force_n = {newtons, 0.0, 0.0};
    view->set_probe(probe);
    view->draw();
    EXPECT_EQ(find_extent(view->read_picture(), is_red, 0, 720).count > 5, is_marked) << newtons;
  }
}

TEST(ProbeFigure, TheDevicesPlaceIsShownInContactOnly) {
  auto view = open_or_fail(plain_settings(StereoMode::mono, 720, 720), {});
  ASSERT_TRUE(view);
  ProbeState state = state_at({0.0, -0.02, 0.0}, {0.0, 0.02, 0.0});
  for (const bool contact : {false, true}) {
    state.contact = contact;
    view->set_probe(make_shown_probe(state, make_lean(0.9)));
    view->draw();
    const Extent red = find_extent(view->read_picture(), is_red, 0, 720);
    EXPECT_EQ(red.count > 20, contact);
    if (!contact) continue;
    const Vec2 device = project_to_pixel(view->screen(), Eye::centre, {720, 720}, state.p_WD);
    EXPECT_NEAR(red.min_y, device.y(), 6.0) << "the line ends there";
  }
}

TEST(ProbeFigure, TwoHandsHaveTheirOwnColours) {
  auto view = open_or_fail(plain_settings(StereoMode::mono, 720, 720), {});
  ASSERT_TRUE(view);
  ProbeShown probe;
  probe.q_WT = make_lean(0.9);
  view->set_other_probe(probe);
  view->draw();
  EXPECT_EQ(find_extent(view->read_picture(), is_tip, 0, 720).count, 0) << "not the first hand's yellow";
  EXPECT_GT(find_extent(view->read_picture(), is_blue, 0, 720).count, 20);
}

TEST(ProbeFigure, TheTipsShadowLiesOnTheGroundBelowIt) {
  ViewSettings settings = plain_settings(StereoMode::mono, 720, 720);
  settings.plain = false;
  settings.framing.pitch_rad = 0.5;
  auto view = open_or_fail(settings, {});
  ASSERT_TRUE(view);
  view->draw();
  const Picture without = view->read_picture();
  ProbeShown probe;
  probe.p_WP = Vec3(0.02, 0.03, 0.01);
  view->set_probe(probe);
  view->draw();
  const Picture with = view->read_picture();
  const Vec2 at = project_to_pixel(view->screen(), Eye::centre, {720, 720}, *find_shadow(probe.p_WP));
  const auto brightness = [&](const Picture& picture) {
    const std::uint8_t* rgb = picture.at(static_cast<int>(at.x()), static_cast<int>(at.y()));
    return int{rgb[0]} + rgb[1] + rgb[2];
  };
  EXPECT_LT(brightness(with), 60);
  EXPECT_GT(brightness(without), brightness(with));
  view->set_depth_cues(false);
  view->set_probe(probe);
  view->draw();
  EXPECT_GT(brightness(view->read_picture()), 60) << "no ground, no shadow";
}

TEST(ProbeFigure, OrientationTurnsTheStylus) {
  auto view = open_or_fail(plain_settings(StereoMode::mono, 360, 360), {});
  ASSERT_TRUE(view);
  ProbeShown probe;
  probe.q_WT = make_lean(1.2);
  view->set_probe(probe);
  view->draw();
  const Picture upright = view->read_picture();
  probe.q_WT = Eigen::AngleAxisd(std::numbers::pi, Vec3::UnitZ()) * probe.q_WT;
  view->set_probe(probe);
  view->draw();
  const Picture hanging = view->read_picture();
  const auto middle = centroid(upright, 0, 0, 360);
  const auto turned = centroid(hanging, 0, 0, 360);
  ASSERT_TRUE(middle && turned);
  EXPECT_GT(middle->y(), 200.0);
  EXPECT_LT(turned->y(), 160.0);
}

}  // namespace
}  // namespace hapton
