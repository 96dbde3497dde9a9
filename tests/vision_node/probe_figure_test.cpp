#include "vision_node/probe_figure.h"

#include <gtest/gtest.h>

#include "tests/vision_node/made_views.h"

namespace hapton {
namespace {

constexpr PictureSize kEye{640, 720};

bool is_tip(const std::uint8_t* rgb) { return rgb[0] > 90 && rgb[2] * 3 < rgb[0] && rgb[1] * 2 > rgb[0]; }
bool is_arrow(const std::uint8_t* rgb) { return rgb[1] > 90 && rgb[0] * 2 < rgb[1] && rgb[2] < rgb[1]; }

struct Extent {
  int count = 0;
  int min_x = 1 << 20;
  int min_y = 1 << 20;
};

Extent measure(const Picture& picture, bool (*wanted)(const std::uint8_t*), int from, int to) {
  Extent extent;
  for (int y = 0; y < picture.size.height_px; ++y) {
    for (int x = from; x < to; ++x) {
      if (!wanted(picture.at(x, y))) continue;
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
  EXPECT_EQ(measure(view->read_picture(), is_tip, 0, 1280).count, 0);
}

// The body leans up and to the right, so the ball's left and lower edges are always seen: they lie a radius from its centre.
TEST(ProbeFigure, TipIsDrawnAtDevicePositionPlusVisualOffsetInBothEyes) {
  auto view = open_or_fail(plain_settings(StereoMode::side_by_side, 1280, 720), {});
  ASSERT_TRUE(view);
  const StereoScreen screen = view->screen();
  for (const Vec3& p_WD : {Vec3(0, 0, 0), Vec3(-0.05, 0.03, 0.07), Vec3(0.04, -0.06, -0.08)}) {
    const Vec3 offset(0.004, 0.011, -0.006);
    view->set_probe(show_probe(state_at(p_WD, offset), make_lean(1.2)));
    view->draw();
    const Picture picture = view->read_picture();
    for (const auto& [eye, from] : {std::pair(Eye::left, 0), std::pair(Eye::right, 640)}) {
      const Vec2 centre = project_to_pixel(screen, eye, kEye, p_WD + offset);
      const double stretch = screen.distance_m / (screen.distance_m - (p_WD + offset).z());
      const double radius_px = view->probe_sizes().tip_radius_m * stretch * 640 / screen.width_m;
      const Extent tip = measure(picture, is_tip, from, from + 640);
      ASSERT_GT(tip.count, 10);
      EXPECT_NEAR(tip.min_x, centre.x() - radius_px, 1.5);
      EXPECT_NEAR(tip.min_y, centre.y() - radius_px, 1.5);
    }
  }
}

TEST(ProbeFigure, OffsetAndPositionAddUp) {
  auto view = open_or_fail(plain_settings(StereoMode::side_by_side, 640, 360), {});
  ASSERT_TRUE(view);
  view->set_probe(show_probe(state_at({0.01, 0.02, 0.03}, {0.01, -0.02, 0.005})));
  view->draw();
  const Picture offset = view->read_picture();
  view->set_probe(show_probe(state_at({0.02, 0.0, 0.035}, Vec3::Zero())));
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
  EXPECT_EQ(measure(view->read_picture(), is_arrow, 0, 640).count, 0);
  for (const Vec3& direction : {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 1, 0), Vec3(0, -1, 0), Vec3(0, 0, 1), Vec3(0, 0, -1)}) {
    int smaller = 0;
    for (const double newtons : {0.5, 2.0}) {
      probe.force_n = newtons * direction;
      view->set_probe(probe);
      view->draw();
      const int now = measure(view->read_picture(), is_arrow, 0, 640).count;
      EXPECT_GT(now, 10) << direction.transpose() << " " << newtons << " N";
      if (direction.z() == 0.0) {
        EXPECT_GT(now, smaller);
      }
      smaller = now;
    }
  }
}

TEST(ProbeFigure, ArrowIsSeenThroughTheObjectItPointsInto) {
  auto wall = std::make_shared<TriangleMesh>();
  wall->vertices = {{-1, -1, 0.05}, {1, -1, 0.05}, {0, 1, 0.05}};
  wall->triangles = {{0, 1, 2}};
  auto view = open_or_fail(plain_settings(StereoMode::side_by_side, 1280, 720), {{wall, {0.5, 0.1, 0.1}}});
  ASSERT_TRUE(view);
  ProbeShown probe;
  probe.q_WT = make_lean(0.9);
  probe.force_n = {1.5, 0.5, -1.0};
  view->set_probe(probe);
  view->draw();
  const Picture picture = view->read_picture();
  EXPECT_GT(measure(picture, is_arrow, 0, 640).count, 100);
  EXPECT_GT(measure(picture, is_arrow, 640, 1280).count, 100);
  EXPECT_EQ(measure(picture, is_tip, 0, 1280).count, 0) << "the wall hides the probe itself";
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
