#include "vision_node/hand_route.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>

#include <gtest/gtest.h>

#include "core/force/force_method.h"
#include "tests/vision_node/made_surface.h"

namespace hapton {
namespace {

constexpr PictureSize kRoutePicture{400, 400};
constexpr double kBackgroundDepth = std::numeric_limits<double>::infinity();

class HandRoute : public testing::Test {
 protected:
  HandRoute() : screen_(compute_screen(frame_sphere(Vec3::Zero(), 0.12, 0.063), kRoutePicture)) {
    side_m_ = std::min(screen_.width_m, screen_.height_m);
  }

  // The hand pulls the device by a millimetre in each step. The visible surface stops the tip where the hand reaches it from the front.
  // deepest_m: how far the device was behind the visible surface, once it had been in front of it.
  struct Walk {
    Vec3 p_WD;  // the device
    double deepest_m = 0.0;
    int steps = 0;
    double distance_m = 0.0;
  };
  Walk walk(const VisibleDepth& seen, const Vec3& from, const Vec3& p_WG) const {
    constexpr double kStep = 0.001;  // m
    Walk walk{from};
    bool is_in_front = false;
    for (; walk.steps < 4000 && (walk.p_WD - p_WG).norm() > kStep; ++walk.steps) {
      const Vec2 pixel = seen.pixel_of(walk.p_WD);
      const double within_m = seen.depth_of(walk.p_WD) - seen.depth_m(pixel);
      is_in_front = is_in_front || within_m <= 0.0;
      const bool touches = is_in_front && within_m > 0.0;
      if (touches) walk.deepest_m = std::max(walk.deepest_m, within_m);
      const Vec3 p_WP = touches ? seen.place(pixel, seen.depth_m(pixel)) : walk.p_WD;
      const Vec3 way = route_hand(seen, {p_WP, p_WP - walk.p_WD}, p_WG) - walk.p_WD;
      const Vec3 step = way.norm() > kStep ? Vec3(kStep * way.normalized()) : way;
      walk.p_WD += step;
      walk.distance_m += step.norm();
    }
    return walk;
  }

  StereoScreen screen_;
  double side_m_ = 0.0;
};

TEST_F(HandRoute, GoesStraightWhereNothingIsInBetween) {
  const VisibleDepth seen = make_visible_depth(screen_, kRoutePicture, [&](double, double) { return screen_.distance_m; });
  const Vec3 goal = seen.place({300.0, 200.0}, screen_.distance_m + 0.003);
  EXPECT_EQ(route_hand(seen, {seen.place({100.0, 200.0}, screen_.distance_m)}, goal), goal);
  EXPECT_EQ(route_hand(seen, {seen.place({100.0, 200.0}, screen_.distance_m - 0.1)}, goal), goal);
}

TEST_F(HandRoute, OverAWallAndDownOnItsOtherSide) {
  const VisibleDepth seen = make_visible_depth(screen_, kRoutePicture, [&](double x, double) {
    return std::abs(x - 200.0) < 20.0 ? screen_.distance_m - 0.06 : screen_.distance_m;
  });
  const Vec3 from = seen.place({100.0, 200.0}, screen_.distance_m);
  const Vec3 goal = seen.place({300.0, 180.0}, screen_.distance_m + 0.003);
  const Walk walked = walk(seen, from, goal);
  EXPECT_LT((walked.p_WD - goal).norm(), 0.0011) << "it comes there";
  EXPECT_LT(walked.deepest_m, 0.021 * side_m_) << "without going through";
  EXPECT_LT(walked.distance_m, 2.5 * ((goal - from).norm() + 0.06)) << "and without long detours";
}

TEST_F(HandRoute, SlidesOverATinyStep) {
  const VisibleDepth seen =
      make_visible_depth(screen_, kRoutePicture, [&](double x, double) { return screen_.distance_m - 0.002 * std::sin(0.1 * x); });
  const Vec3 goal = seen.place({300.0, 200.0}, screen_.distance_m + 0.002);
  EXPECT_EQ(route_hand(seen, {seen.place({100.0, 200.0}, screen_.distance_m)}, goal), goal);
}

TEST_F(HandRoute, FromBehindAnObjectOutBesideItAndToItsFront) {
  const auto plate = [&](double x, double y) { return std::hypot(x - 200.0, y - 200.0) < 80.0 ? screen_.distance_m : kBackgroundDepth; };
  const VisibleDepth seen = make_visible_depth(screen_, kRoutePicture, plate);
  const Vec3 from = seen.place({190.0, 205.0}, screen_.distance_m + 0.04);
  const Vec3 goal = seen.place({200.0, 200.0}, screen_.distance_m + 0.003);
  const Walk walked = walk(seen, from, goal);
  EXPECT_LT((walked.p_WD - goal).norm(), 0.0011);
  EXPECT_GT(walked.distance_m, 0.1) << "round the rim: straight it would be 40 mm";
  EXPECT_LT(walked.deepest_m, 0.0041) << "no deeper than the goal is, and a step";
}

// The back of a thin sheet is as far away as its front: the direction from the device to the tip tells which side the tip touches.
TEST_F(HandRoute, FromTheBackOfAThinSheetOutBesideItAndOnItsFrontStraight) {
  const auto plate = [&](double x, double y) { return std::hypot(x - 200.0, y - 200.0) < 80.0 ? screen_.distance_m : kBackgroundDepth; };
  const VisibleDepth seen = make_visible_depth(screen_, kRoutePicture, plate);
  const Vec3 p_WP = seen.place({190.0, 205.0}, screen_.distance_m);
  const Vec3 goal = seen.place({230.0, 200.0}, screen_.distance_m + 0.003);
  EXPECT_EQ(route_hand(seen, {p_WP, Vec3(0.0, 0.0, 0.003)}, goal), goal);
  const Vec2 out = seen.pixel_of(route_hand(seen, {p_WP, Vec3(0.0, 0.0, -0.003)}, goal));
  EXPECT_GT(std::hypot(out.x() - 200.0, out.y() - 200.0), 80.0);
}

// A method decides where the tip is: the hand pulls the device, and the method keeps the tip on the side that it touched first.
class LedThroughAMethod : public HandRoute {
 protected:
  static constexpr double kHalfSide = 0.05;

  // A sheet without thickness through the middle of the picture.
  LedThroughAMethod() {
    TriangleMesh sheet{
        .vertices = {{-kHalfSide, -kHalfSide, 0}, {kHalfSide, -kHalfSide, 0}, {kHalfSide, kHalfSide, 0}, {-kHalfSide, kHalfSide, 0}},
        .triangles = {{0, 1, 2}, {0, 2, 3}}};
    scene_.objects.push_back({std::make_shared<const TriangleMesh>(std::move(sheet)), {}});
  }

  VisibleDepth see_sheet() const {
    const Vec2 corner = project_to_pixel(screen_, Eye::centre, kRoutePicture, {kHalfSide, kHalfSide, 0.0});
    return make_visible_depth(screen_, kRoutePicture, [&](double x, double y) {
      return std::abs(x - 200.0) < corner.x() - 200.0 && std::abs(y - 200.0) < corner.y() - 200.0 ? screen_.distance_m : kBackgroundDepth;
    });
  }

  // Three seconds of a hand at 0.3 m/s that receives a new goal every 4 ms. pressed: where the device has moved at the beginning, through
  // the back of the sheet.
  MethodOutput lead(const Vec3& from, const Vec3& goal, bool uses_route, const std::optional<Vec3>& pressed = {}) const {
    const auto method = make_method({}, scene_);
    if (!method) throw std::runtime_error(method.error().what);
    const VisibleDepth seen = see_sheet();
    Vec3 p_WD = from;
    Vec3 target = goal;
    (*method)->reset(p_WD);
    MethodOutput output{.p_SP = p_WD};
    if (pressed) {
      p_WD = *pressed;
      output = (*method)->step({.p_SD = p_WD});
      EXPECT_LT(output.force_n.z(), -0.1) << "it touches the back";
    }
    for (int ms = 0; ms < 3000; ++ms) {
      if (uses_route && ms % 4 == 0)
        target = route_hand(seen, {output.p_SP, output.contact ? Vec3(output.p_SP - p_WD) : Vec3(Vec3::Zero())}, goal);
      const Vec3 way = target - p_WD;
      p_WD += way.norm() > 0.0003 ? Vec3(0.0003 * way.normalized()) : way;
      output = (*method)->step({.p_SD = p_WD});
    }
    return output;
  }

  TouchScene scene_;
};

TEST_F(LedThroughAMethod, FromBehindItComesToTheFrontAndPressesThere) {
  for (const Vec3& from : {Vec3(0.005, 0.002, -0.03), Vec3(-0.03, 0.04, -0.002), Vec3(0.0, 0.0, -0.08)}) {
    const Vec3 goal(0.01, 0.0, -0.003);
    const MethodOutput straight = lead(from, goal, false);
    ASSERT_LE(straight.force_n.z(), 0.0) << "straight it stays behind";
    const MethodOutput led = lead(from, goal, true);
    EXPECT_TRUE(led.contact);
    EXPECT_GT(led.force_n.z(), 0.0) << "pressed from the side that is seen";
    EXPECT_NEAR(led.p_SP.z(), 0.0, 1e-4);
    EXPECT_LT((led.p_SP - Vec3(0.01, 0.0, 0.0)).norm(), 0.001);
  }
}

TEST_F(LedThroughAMethod, InTouchWithTheBackItComesToTheFront) {
  const Vec3 goal(0.01, 0.0, -0.003), pressed(0.0, 0.01, 0.0005);
  ASSERT_LE(lead({0.0, 0.01, -0.0005}, goal, false, pressed).force_n.z(), 0.0) << "straight it stays behind";
  const MethodOutput led = lead({0.0, 0.01, -0.0005}, goal, true, pressed);
  EXPECT_GT(led.force_n.z(), 0.0);
  EXPECT_LT((led.p_SP - Vec3(0.01, 0.0, 0.0)).norm(), 0.001);
}

TEST_F(HandRoute, TakesTheNearestWayOut) {
  const auto plate = [&](double x, double y) {
    return x > 50.0 && x < 350.0 && y > 180.0 && y < 380.0 ? screen_.distance_m : kBackgroundDepth;
  };
  const VisibleDepth seen = make_visible_depth(screen_, kRoutePicture, plate);
  const Vec3 from = seen.place({200.0, 200.0}, screen_.distance_m + 0.04);
  const Vec2 out = seen.pixel_of(route_hand(seen, {from}, seen.place({200.0, 370.0}, screen_.distance_m)));
  EXPECT_LT(out.y(), 180.0);
  EXPECT_NEAR(out.x(), 200.0, 10.0);
}

TEST_F(HandRoute, WhereNothingIsSeenOfAWayOutItGoesStraight) {
  const VisibleDepth seen = make_visible_depth(screen_, kRoutePicture, [&](double, double) { return screen_.distance_m; });
  const Vec3 goal(1.0, 0.0, screen_.distance_m + 1.0);
  EXPECT_EQ(route_hand(seen, {}, goal), goal) << "behind the viewer";
}

}  // namespace
}  // namespace hapton
