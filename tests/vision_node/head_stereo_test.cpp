// Draws frames for heads in front of the screen: in every mode each eye's picture of a point is within half a pixel of where the line from
// that eye to the point crosses the screen.
#include <array>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/vision_node/made_views.h"

namespace hapton {
namespace {

constexpr int kWidth = 640, kHeight = 480;
constexpr double kIpd = 0.063;
constexpr double kTolerancePx = 0.5;
const Vec3 kNear(0.03, 0.02, 0.07), kFar(-0.04, 0.03, -0.08), kOnScreen(0.05, -0.06, 0.0);

struct NamedHead {
  std::string name;
  Head head;
};

std::vector<NamedHead> heads() {
  const auto turned = [](double radians, const Vec3& axis) { return Quat(Eigen::AngleAxisd(radians, axis)); };
  return {{"in the middle", {}},
          {"left", {{-0.15, 0.0, 0.6}, Quat::Identity()}},
          {"right and up", {{0.12, 0.1, 0.6}, Quat::Identity()}},
          {"near", {{0.0, 0.0, 0.35}, Quat::Identity()}},
          {"far", {{0.02, 0.0, 1.2}, Quat::Identity()}},
          {"tilted", {{0.0, 0.0, 0.6}, turned(0.5, Vec3::UnitZ())}},
          {"turned", {{0.05, 0.03, 0.5}, turned(0.8, Vec3::UnitY())}}};
}

// The screen is the plane z = 0 of the world, with its centre at the origin: this needs no matrix and none of the tested code.
Vec2 closed_form_pixel(const Head& head, Eye eye, const Vec3& p, const Framing& framing, Vec2 pixels) {
  const double side = eye == Eye::left ? -0.5 : eye == Eye::right ? 0.5 : 0.0;
  const Vec3 e = head.p_RH + side * kIpd * (head.q_RH * Vec3::UnitX());
  const double x = e.x() + (p.x() - e.x()) * e.z() / (e.z() - p.z());
  const double y = e.y() + (p.y() - e.y()) * e.z() / (e.z() - p.z());
  const double height_m = framing.view_m;
  const double width_m = height_m * kWidth / kHeight;
  return {(x / width_m + 0.5) * pixels.x(), (y / height_m + 0.5) * pixels.y()};
}

// Middle of the bright pixels of one channel near a pixel, weighted by brightness. The other eye's image of the marker is farther away.
std::optional<Vec2> middle_near(const Picture& picture, int channel, const Vec2& at, const Vec2& reach) {
  Vec2 sum = Vec2::Zero();
  double weight = 0.0;
  for (int y = 0; y < picture.size.height_px; ++y) {
    for (int x = 0; x < picture.size.width_px; ++x) {
      const Vec2 pixel(x + 0.5, y + 0.5);
      if (((pixel - at).cwiseAbs().array() > reach.array()).any()) continue;
      sum += picture.at(x, y)[channel] * pixel;
      weight += picture.at(x, y)[channel];
    }
  }
  return weight > 0.0 ? std::optional(Vec2(sum / weight)) : std::nullopt;
}

// How a mode shows one eye: from which pixel of the window on, how large the eye's picture is there, and in which channel.
struct EyePlacement {
  Eye eye;
  Vec2 from = Vec2::Zero();
  Vec2 size = Vec2(kWidth, kHeight);
  int channel = 0;
};

std::vector<EyePlacement> placements_in(StereoMode mode) {
  const Vec2 half_width(0.5 * kWidth, kHeight), half_height(kWidth, 0.5 * kHeight);
  switch (mode) {
    case StereoMode::mono:
      return {{Eye::centre}};
    case StereoMode::left:
    case StereoMode::fake:
      return {{Eye::left}};
    case StereoMode::right:
      return {{Eye::right}};
    case StereoMode::side_by_side:  // in a window twice as wide: nothing is squeezed
      return {{Eye::left}, {Eye::right, Vec2(kWidth, 0)}};
    case StereoMode::top_bottom:
      return {{Eye::left, Vec2(0, 0.5 * kHeight), half_height}, {Eye::right, Vec2(0, 0), half_height}};
    case StereoMode::split_viewport:
      return {{Eye::left, Vec2(0, 0), half_width}, {Eye::right, Vec2(0.5 * kWidth, 0), half_width}};
    case StereoMode::red_blue:
    case StereoMode::anaglyph:
      return {{.eye = Eye::left, .channel = 0}, {.eye = Eye::right, .channel = 2}};
    default:
      return {{Eye::left}, {Eye::right}};
  }
}

void expect_marker(const Picture& picture, const EyePlacement& placement, const NamedHead& named, const Vec3& p_W, const Framing& framing) {
  const Vec2 theory = placement.from + closed_form_pixel(named.head, placement.eye, p_W, framing, placement.size);
  const Vec2 reach = Vec2(18.0, 18.0).cwiseProduct(placement.size.cwiseQuotient(Vec2(kWidth, kHeight)));
  const auto found = middle_near(picture, placement.channel, theory, reach);
  ASSERT_TRUE(found) << named.name;
  EXPECT_LT((*found - theory).norm(), kTolerancePx) << named.name << ", eye " << static_cast<int>(placement.eye) << ", found "
                                                    << found->transpose() << ", expected " << theory.transpose();
}

Framing framing_of(const ViewSettings& settings, const NamedHead& named) {
  Framing framing = settings.framing;
  framing.head = named.head;
  return framing;
}

Picture draw_picture(StereoView& view, const Framing& framing) {
  view.set_framing(framing);
  view.draw();
  return view.read_picture();
}

void expect_every_head(StereoMode mode) {
  const int width_px = mode == StereoMode::side_by_side ? 2 * kWidth : kWidth;
  for (const Vec3& p_W : {kNear, kFar, kOnScreen}) {
    ViewSettings settings = plain_settings(mode, width_px, kHeight);
    auto view = open_or_fail(settings, {{make_marker(p_W, 0.004), Vec3(1, 1, 1)}});
    ASSERT_TRUE(view);
    for (const NamedHead& named : heads()) {
      const Framing framing = framing_of(settings, named);
      const Picture picture = draw_picture(*view, framing);
      for (const EyePlacement& placement : placements_in(mode)) expect_marker(picture, placement, named, p_W, framing);
    }
  }
}

TEST(HeadStereo, Mono) { expect_every_head(StereoMode::mono); }
TEST(HeadStereo, SideBySide) { expect_every_head(StereoMode::side_by_side); }
TEST(HeadStereo, TopBottom) { expect_every_head(StereoMode::top_bottom); }
TEST(HeadStereo, RedBlue) { expect_every_head(StereoMode::red_blue); }
TEST(HeadStereo, Anaglyph) { expect_every_head(StereoMode::anaglyph); }
TEST(HeadStereo, SplitViewport) { expect_every_head(StereoMode::split_viewport); }
TEST(HeadStereo, Left) { expect_every_head(StereoMode::left); }
TEST(HeadStereo, Right) { expect_every_head(StereoMode::right); }
TEST(HeadStereo, Fake) { expect_every_head(StereoMode::fake); }

// Both eyes' images of a marker are in one picture, apart from each other: each eye has every second row, column or pixel.
void expect_woven(StereoMode mode) {
  // The markers are so far in front of the screen or behind it that the images of the two eyes do not overlap.
  for (const Vec3& p_W : {Vec3(0.02, 0.02, 0.1), Vec3(-0.02, 0.02, -0.18)}) {
    ViewSettings settings = plain_settings(mode, kWidth, kHeight);
    auto view = open_or_fail(settings, {{make_marker(p_W, 0.002), Vec3(1, 1, 1)}});
    ASSERT_TRUE(view);
    for (const NamedHead& named : heads()) {
      const Framing framing = framing_of(settings, named);
      const Picture picture = draw_picture(*view, framing);
      const Vec2 left = closed_form_pixel(named.head, Eye::left, p_W, framing, Vec2(kWidth, kHeight));
      const Vec2 right = closed_form_pixel(named.head, Eye::right, p_W, framing, Vec2(kWidth, kHeight));
      const double reach = 0.5 * (left - right).cwiseAbs().maxCoeff();
      ASSERT_GT(reach, 5.0) << named.name << ": they are apart";
      for (const Vec2& theory : {left, right}) {
        const auto found = middle_near(picture, 0, theory, Vec2(reach, reach));
        ASSERT_TRUE(found) << named.name;
        EXPECT_LT((*found - theory).norm(), kTolerancePx)
            << named.name << ", found " << found->transpose() << ", expected " << theory.transpose();
      }
    }
  }
}

TEST(HeadStereo, Interlaced) { expect_woven(StereoMode::interlaced); }
TEST(HeadStereo, Dresden) { expect_woven(StereoMode::dresden); }
TEST(HeadStereo, Checkerboard) { expect_woven(StereoMode::checkerboard); }

TEST(HeadStereo, EmulateShowsBothEyesInTurn) {
  const ViewSettings settings = plain_settings(StereoMode::emulate, kWidth, kHeight);
  auto view = open_or_fail(settings, {{make_marker(kNear, 0.004), Vec3(1, 1, 1)}});
  ASSERT_TRUE(view);
  for (const NamedHead& named : heads()) {
    Framing framing = settings.framing;
    framing.head = named.head;
    view->set_framing(framing);
    std::array<bool, 2> is_shown = {};
    for (int frame = 0; frame < 2; ++frame) {
      view->draw();
      const auto found = centroid(view->read_picture(), 0, 0, kWidth);
      ASSERT_TRUE(found);
      for (const Eye eye : {Eye::left, Eye::right}) {
        const Vec2 theory = closed_form_pixel(named.head, eye, kNear, framing, Vec2(kWidth, kHeight));
        if ((*found - theory).norm() < kTolerancePx) is_shown[eye == Eye::right] = true;
      }
    }
    EXPECT_TRUE(is_shown[0] && is_shown[1]) << named.name;
  }
}

// The hand is led to the point that is seen, so the point must be right for both eyes, even if a turned head brings one nearer.
TEST(HeadStereo, ThePointUnderAPixelIsTheMarkers) {
  const ViewSettings settings = plain_settings(StereoMode::side_by_side, 2 * kWidth, kHeight);
  auto view = open_or_fail(settings, {{make_marker(kNear, 0.01), Vec3(1, 1, 1)}});
  ASSERT_TRUE(view);
  for (const NamedHead& named : heads()) {
    Framing framing = settings.framing;
    framing.head = named.head;
    view->set_framing(framing);
    view->draw();
    for (const Eye eye : {Eye::left, Eye::right}) {
      const Vec2 at = closed_form_pixel(named.head, eye, kNear, framing, Vec2(kWidth, kHeight)) + Vec2(eye == Eye::right ? kWidth : 0, 0);
      const auto p_W = view->pick(static_cast<int>(at.x()), static_cast<int>(at.y()));
      ASSERT_TRUE(p_W) << named.name;
      EXPECT_NEAR((*p_W - kNear).norm(), 0.01, 5e-4) << named.name;
    }
    const auto visible = view->visible_depth();
    ASSERT_TRUE(visible);
    const Vec2 at = closed_form_pixel(named.head, Eye::left, kNear, framing, Vec2(kWidth, kHeight));
    const auto p_W = visible->find(at);
    ASSERT_TRUE(p_W) << named.name;
    EXPECT_NEAR((*p_W - kNear).norm(), 0.01, 5e-4) << named.name;
    EXPECT_NEAR(visible->depth_of(*p_W), visible->depth_m(at), 1e-4) << named.name;
  }
}

}  // namespace
}  // namespace hapton
