#include "vision_node/hand_route.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/vision_node/made_surface.h"

namespace hapton {
namespace {

constexpr PictureSize kPicture{400, 400};
constexpr double kNothing = std::numeric_limits<double>::infinity();

class HandRoute : public testing::Test {
 protected:
  HandRoute() : screen_(compute_screen(frame_sphere(Vec3::Zero(), 0.12, 0.063), kPicture)) {
    side_m_ = std::min(screen_.width_m, screen_.height_m);
  }

  // Pulled by a millimetre a turn. How deep within or behind what is seen it comes on the way, once it has been in front of it.
  struct Walk {
    Vec3 p_W;
    double deepest_m = 0.0;
    int steps = 0;
    double distance_m = 0.0;
  };
  Walk walk(const SurfaceSeen& seen, const Vec3& p_WP, const Vec3& p_WG) const {
    constexpr double kPace = 0.001;
    Walk walk{p_WP};
    bool was_in_front = false;
    for (; walk.steps < 4000 && (walk.p_W - p_WG).norm() > kPace; ++walk.steps) {
      const Vec3 way = route_hand(seen, {walk.p_W}, p_WG) - walk.p_W;
      const Vec3 step = way.norm() > kPace ? Vec3(kPace * way.normalized()) : way;
      walk.p_W += step;
      walk.distance_m += step.norm();
      const double within_m = seen.depth_of(walk.p_W) - seen.depth_m(seen.pixel_of(walk.p_W));
      was_in_front = was_in_front || within_m <= 0.0;
      if (was_in_front) walk.deepest_m = std::max(walk.deepest_m, within_m);
    }
    return walk;
  }

  StereoScreen screen_;
  double side_m_ = 0.0;
};

TEST_F(HandRoute, GoesStraightWhereNothingIsInBetween) {
  const SurfaceSeen seen = make_surface(screen_, kPicture, [&](double, double) { return screen_.distance_m; });
  const Vec3 goal = seen.place({300.0, 200.0}, screen_.distance_m + 0.003);
  EXPECT_EQ(route_hand(seen, {seen.place({100.0, 200.0}, screen_.distance_m)}, goal), goal);
  EXPECT_EQ(route_hand(seen, {seen.place({100.0, 200.0}, screen_.distance_m - 0.1)}, goal), goal);
}

TEST_F(HandRoute, OverAWallAndDownOnItsOtherSide) {
  const SurfaceSeen seen = make_surface(
      screen_, kPicture, [&](double x, double) { return std::abs(x - 200.0) < 20.0 ? screen_.distance_m - 0.06 : screen_.distance_m; });
  const Vec3 from = seen.place({100.0, 200.0}, screen_.distance_m);
  const Vec3 goal = seen.place({300.0, 180.0}, screen_.distance_m + 0.003);
  const Walk walked = walk(seen, from, goal);
  EXPECT_LT((walked.p_W - goal).norm(), 0.0011) << "it comes there";
  EXPECT_LT(walked.deepest_m, 0.021 * side_m_) << "without going through";
  EXPECT_LT(walked.distance_m, 2.5 * ((goal - from).norm() + 0.06)) << "and without long detours";
}

TEST_F(HandRoute, SlidesOverWhatHardlyStandsOut) {
  const SurfaceSeen seen =
      make_surface(screen_, kPicture, [&](double x, double) { return screen_.distance_m - 0.002 * std::sin(0.1 * x); });
  const Vec3 goal = seen.place({300.0, 200.0}, screen_.distance_m + 0.002);
  EXPECT_EQ(route_hand(seen, {seen.place({100.0, 200.0}, screen_.distance_m)}, goal), goal);
}

TEST_F(HandRoute, FromBehindAnObjectOutBesideItAndToItsFront) {
  const auto plate = [&](double x, double y) { return std::hypot(x - 200.0, y - 200.0) < 80.0 ? screen_.distance_m : kNothing; };
  const SurfaceSeen seen = make_surface(screen_, kPicture, plate);
  const Vec3 from = seen.place({190.0, 205.0}, screen_.distance_m + 0.04);
  const Vec3 goal = seen.place({200.0, 200.0}, screen_.distance_m + 0.003);
  const Walk walked = walk(seen, from, goal);
  EXPECT_LT((walked.p_W - goal).norm(), 0.0011);
  // Where it passes the plate's depth it is beside it, not in it.
  Vec3 p_W = from;
  bool crossed_beside = false;
  for (int i = 0; i < 4000 && (p_W - goal).norm() > 0.001; ++i) {
    const double before_m = seen.depth_of(p_W);
    p_W += 0.001 * (route_hand(seen, {p_W}, goal) - p_W).normalized();
    if (before_m > screen_.distance_m && seen.depth_of(p_W) <= screen_.distance_m) {
      const Vec2 at = seen.pixel_of(p_W);
      EXPECT_GT(std::hypot(at.x() - 200.0, at.y() - 200.0), 80.0);
      crossed_beside = true;
    }
  }
  EXPECT_TRUE(crossed_beside);
}

// As far away as its front: which side it touches is said by where it is kept out to.
TEST_F(HandRoute, FromTheBackOfAThinSheetOutBesideItAndOnItsFrontStraight) {
  const auto plate = [&](double x, double y) { return std::hypot(x - 200.0, y - 200.0) < 80.0 ? screen_.distance_m : kNothing; };
  const SurfaceSeen seen = make_surface(screen_, kPicture, plate);
  const Vec3 p_WP = seen.place({190.0, 205.0}, screen_.distance_m);
  const Vec3 goal = seen.place({230.0, 200.0}, screen_.distance_m + 0.003);
  EXPECT_EQ(route_hand(seen, {p_WP, Vec3(0.0, 0.0, 0.003)}, goal), goal);
  const Vec2 out = seen.pixel_of(route_hand(seen, {p_WP, Vec3(0.0, 0.0, -0.003)}, goal));
  EXPECT_GT(std::hypot(out.x() - 200.0, out.y() - 200.0), 80.0);
}

TEST_F(HandRoute, TakesTheNearestWayOut) {
  const auto plate = [&](double x, double y) { return x > 50.0 && x < 350.0 && y > 180.0 && y < 380.0 ? screen_.distance_m : kNothing; };
  const SurfaceSeen seen = make_surface(screen_, kPicture, plate);
  const Vec3 from = seen.place({200.0, 200.0}, screen_.distance_m + 0.04);
  const Vec2 out = seen.pixel_of(route_hand(seen, {from}, seen.place({200.0, 370.0}, screen_.distance_m)));
  EXPECT_LT(out.y(), 180.0);
  EXPECT_NEAR(out.x(), 200.0, 10.0);
}

TEST_F(HandRoute, WhereNothingIsSeenOfAWayOutItGoesStraight) {
  const SurfaceSeen seen = make_surface(screen_, kPicture, [&](double, double) { return screen_.distance_m; });
  const Vec3 goal(1.0, 0.0, screen_.distance_m + 1.0);
  EXPECT_EQ(route_hand(seen, {}, goal), goal) << "behind the viewer";
}

}  // namespace
}  // namespace hapton
