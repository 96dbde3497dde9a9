// Frames drawn for screens in any pose: each eye's picture of a point is within half a pixel of where the line from the eye to the point
// crosses the screen's rectangle.
#include <gtest/gtest.h>

#include <numbers>
#include <string>
#include <vector>

#include "tests/vision_node/made_views.h"

namespace hapton {
namespace {

constexpr int kScreenWidthPx = 640, kScreenHeightPx = 400;
constexpr double kScreenIpd = 0.063;
const Vec3 kInFront_W(0.02, 0.01, 0.03), kBeside_W(-0.03, 0.0, -0.02);

struct DrawnScreen {
  std::string name;
  Vec3 centre, right, up;  // right and up: axes of length 1, written by hand
  double width_m, height_m;
  Head head;
};

// The inclined axes come from 3-4-5 triangles, so their numbers are exact.
std::vector<DrawnScreen> drawn_screens() {
  const Quat tilted(Eigen::AngleAxisd(0.5, Vec3::UnitZ()));
  return {{"upright", {0.0, 0.0, 0.0}, {1, 0, 0}, {0, 1, 0}, 0.24, 0.15, {}},
          {"upright, off centre head", {0.02, 0.03, -0.06}, {1, 0, 0}, {0, 1, 0}, 0.24, 0.15, {{0.18, -0.1, 0.5}}},
          {"leans back, off centre head", {0.0, -0.03, -0.05}, {1, 0, 0}, {0, 0.8, -0.6}, 0.24, 0.15, {{-0.12, 0.08, 0.45}}},
          {"faces left, tilted head", {0.03, 0.0, -0.03}, {0.8, 0, 0.6}, {0, 1, 0}, 0.2, 0.16, {{0.05, 0.1, 0.6}, tilted}},
          {"a table, pixels not square", {0.0, -0.05, 0.0}, {1, 0, 0}, {0, 0, -1}, 0.2, 0.2, {{0.03, -0.12, 0.5}}}};
}

ViewSettings settings_for(const DrawnScreen& drawn, StereoMode mode) {
  const bool is_wide = mode == StereoMode::side_by_side;
  ViewSettings settings = plain_settings(mode, is_wide ? 2 * kScreenWidthPx : kScreenWidthPx, kScreenHeightPx);
  ScreenRectangle screen{Pose::Identity(), drawn.width_m, drawn.height_m};
  screen.X_WR.translation() = drawn.centre;
  screen.X_WR.linear() << drawn.right, drawn.up, drawn.right.cross(drawn.up);
  settings.framing.screen = screen;
  settings.framing.head = drawn.head;
  return settings;
}

Vec2 expected_pixel(const DrawnScreen& drawn, Eye eye, const Vec3& p_W) {
  const double side = eye == Eye::left ? -0.5 : eye == Eye::right ? 0.5 : 0.0;
  const Vec3 e = drawn.head.p_RH + side * kScreenIpd * (drawn.head.q_RH * Vec3::UnitX());
  const Vec3 from = p_W - drawn.centre;
  const Vec3 p(from.dot(drawn.right), from.dot(drawn.up), from.dot(drawn.right.cross(drawn.up)));
  const double x_m = e.x() + (p.x() - e.x()) * e.z() / (e.z() - p.z());
  const double y_m = e.y() + (p.y() - e.y()) * e.z() / (e.z() - p.z());
  return {(x_m / drawn.width_m + 0.5) * kScreenWidthPx, (y_m / drawn.height_m + 0.5) * kScreenHeightPx};
}

void expect_drawn(const Picture& picture, const DrawnScreen& drawn, Eye eye, const Vec3& p_W, int from_px) {
  const auto found = centroid(picture, 0, from_px, from_px + kScreenWidthPx);
  ASSERT_TRUE(found) << drawn.name;
  const Vec2 expected = expected_pixel(drawn, eye, p_W);
  EXPECT_LT((*found - expected).norm(), 0.5) << drawn.name << ", eye " << static_cast<int>(eye) << ", found " << found->transpose()
                                             << ", expected " << expected.transpose();
}

TEST(ScreenStereo, AMarkerIsDrawnWhereItIsSeenThroughTheScreen) {
  for (const DrawnScreen& drawn : drawn_screens()) {
    for (const Vec3& p_W : {kInFront_W, kBeside_W}) {
      const std::vector<ShownObject> marker = {{make_marker(p_W, 0.003), Vec3(1, 1, 1)}};
      auto mono = open_or_fail(settings_for(drawn, StereoMode::mono), marker);
      ASSERT_TRUE(mono);
      mono->draw();
      expect_drawn(mono->read_picture(), drawn, Eye::centre, p_W, 0);
      auto pair = open_or_fail(settings_for(drawn, StereoMode::side_by_side), marker);
      ASSERT_TRUE(pair);
      pair->draw();
      const Picture both = pair->read_picture();
      expect_drawn(both, drawn, Eye::left, p_W, 0);
      expect_drawn(both, drawn, Eye::right, p_W, kScreenWidthPx);
    }
  }
}

// The mouse leads the hand to the point that is seen under its pixel.
TEST(ScreenStereo, ThePointUnderAPixelIsTheMarkers) {
  for (const DrawnScreen& drawn : drawn_screens()) {
    auto view = open_or_fail(settings_for(drawn, StereoMode::mono), {{make_marker(kInFront_W, 0.01), Vec3(1, 1, 1)}});
    ASSERT_TRUE(view);
    view->draw();
    const Vec2 at = expected_pixel(drawn, Eye::centre, kInFront_W);
    const auto p_W = view->pick(static_cast<int>(at.x()), static_cast<int>(at.y()));
    ASSERT_TRUE(p_W) << drawn.name;
    EXPECT_NEAR((*p_W - kInFront_W).norm(), 0.01, 5e-4) << drawn.name;
  }
}

}  // namespace
}  // namespace hapton
