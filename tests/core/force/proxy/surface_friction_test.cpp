#include "core/force/proxy/surface_friction.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <utility>

#include "core/force/sliding_friction.h"
#include "core/geometry/mesh_shapes.h"
#include "tests/support/surface_stage.h"

namespace hapton {
namespace {

// A surface point with friction, driven from event to event as a follower does.
struct Slider {
  Slider(const TriangleMesh& mesh, double friction_static, double friction_dynamic) : stage(mesh) {
    stage.materials[0].friction_static = friction_static;
    stage.materials[0].friction_dynamic = friction_dynamic;
  }

  bool land(std::uint32_t triangle, const Vec3& p, bool slides = false) {
    if (!stage.point.land(triangle, false, p)) return false;
    friction.begin(stage.point.material(), slides);
    return true;
  }
  SurfaceNext descend(const Vec3& device) {
    SurfaceNext next = SurfaceNext::again;
    for (int i = 0; i < kMaxEvents && next == SurfaceNext::again; ++i) next = friction.descend(stage.point, device);
    return next;
  }
  SurfaceNext follow(const Vec3& from, const Vec3& to, double& time) {
    for (int i = 0; i < kMaxEvents; ++i) {
      SurfaceNext next = friction.follow(stage.point, from, to, time);
      if (next == SurfaceNext::descend) {
        next = descend(on_path(from, to, time));
        if (next == SurfaceNext::settled && time < 1.0) continue;
      }
      if (next != SurfaceNext::again) return next;
    }
    return SurfaceNext::again;
  }
  SurfaceNext follow(const Vec3& from, const Vec3& to) {
    double time = 0.0;
    return follow(from, to, time);
  }
  const Vec3& point() const { return stage.point.point(); }

  static constexpr int kMaxEvents = 1000;
  SurfaceStage stage;
  SurfaceFriction friction;
};

// One triangle in the plane z = 0, larger than every motion here. Its local frame is that of the scene.
TriangleMesh make_plane() {
  TriangleMesh mesh;
  mesh.vertices = {{-0.5, -0.5, 0.0}, {0.5, -0.5, 0.0}, {0.0, 0.5, 0.0}};
  mesh.triangles = {{0, 1, 2}};
  return mesh;
}

Vec3 in_plane(const Vec3& v) { return {v.x(), v.y(), 0.0}; }

// Finds by bisection the time at which the pull leaves the cone. Pre: it leaves the cone once. out_of_cone(time): how
// far the pull is out of the cone, negative inside.
template <class OutOfCone>
double find_slip_time(OutOfCone&& out_of_cone) {
  double low = 0.0;
  double high = 1.0;
  for (int i = 0; i < 60; ++i) (out_of_cone(0.5 * (low + high)) > 0.0 ? high : low) = 0.5 * (low + high);
  return high;
}

TEST(SurfaceFriction, WithoutAStaticCoefficientItDoesNotAct) {
  Slider slider(make_plane(), 0.0, 0.0);
  ASSERT_TRUE(slider.land(0, Vec3::Zero(), true));
  EXPECT_FALSE(slider.friction.acts());
  EXPECT_FALSE(slider.friction.slides());
  ASSERT_EQ(slider.descend(Vec3(0.1, 0.05, -0.2)), SurfaceNext::settled);
  EXPECT_EQ(slider.point(), Vec3(0.1, 0.05, 0.0));  // straight above the device: no pull is left
  slider.stage.materials[0].friction_static = 0.1;
  slider.friction.begin(slider.stage.point.material(), true);
  EXPECT_TRUE(slider.friction.acts());
  EXPECT_TRUE(slider.friction.slides());
  slider.friction.begin(slider.stage.point.material(), false);
  EXPECT_FALSE(slider.friction.slides());
}

TEST(SurfaceFriction, InsideTheStaticConeThePointDoesNotMoveByADigit) {
  std::mt19937_64 random = make_random(3);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  Slider slider(make_plane(), 0.7, 0.3);
  const Vec3 start(0.0123456789, -0.0987654321, 0.0);
  ASSERT_TRUE(slider.land(0, start));
  const auto device_in_cone = [&](double cone_share) {
    const double depth = 0.01 + 0.2 * share(random);
    const double angle = 2.0 * std::numbers::pi * share(random);
    return Vec3(start + cone_share * 0.7 * depth * Vec3(std::cos(angle), std::sin(angle), 0.0) - Vec3(0, 0, depth));
  };
  Vec3 device = device_in_cone(1.0 - 1e-9);
  ASSERT_EQ(slider.descend(device), SurfaceNext::settled);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 to = device_in_cone(i % 2 == 0 ? 1.0 - 1e-9 : share(random));
    double time = 0.0;
    ASSERT_EQ(slider.follow(device, to, time), SurfaceNext::settled);
    ASSERT_EQ(time, 1.0);
    ASSERT_EQ(slider.point(), start) << i;
    ASSERT_FALSE(slider.friction.slides());
    device = to;
  }
}

TEST(SurfaceFriction, BeyondTheStaticConeItGoesToTheDynamicOne) {
  Slider slider(make_plane(), 0.7, 0.3);
  const Vec3 pull = Vec3(0.6, 0.8, 0.0);
  for (const double beyond : {1.0 + 1e-9, 1.2}) {
    ASSERT_TRUE(slider.land(0, Vec3::Zero()));
    const Vec3 device = 0.7 * 0.1 * beyond * pull - Vec3(0, 0, 0.1);
    ASSERT_EQ(slider.descend(device), SurfaceNext::settled);
    EXPECT_TRUE(slider.friction.slides());
    EXPECT_LT((slider.point() - (in_plane(device) - 0.3 * 0.1 * pull)).norm(), 1e-15);
  }
  // A sliding point moves although the pull is within the static cone.
  ASSERT_TRUE(slider.land(0, Vec3::Zero(), true));
  ASSERT_EQ(slider.descend(0.5 * 0.1 * pull - Vec3(0, 0, 0.1)), SurfaceNext::settled);
  EXPECT_LT((slider.point() - 0.2 * 0.1 * pull).norm(), 1e-15);
}

TEST(SurfaceFriction, ADynamicCoefficientIsNoLargerThanTheStaticOne) {
  Slider slider(make_plane(), 0.3, 0.7);
  ASSERT_TRUE(slider.land(0, Vec3::Zero()));
  ASSERT_EQ(slider.descend(Vec3(0.1, 0.0, -0.1)), SurfaceNext::settled);
  EXPECT_LT((slider.point() - Vec3(0.07, 0.0, 0.0)).norm(), 1e-15);
}

TEST(SurfaceFriction, InFrontOfTheFaceItIsAirborne) {
  Slider slider(make_plane(), 0.5, 0.5);
  ASSERT_TRUE(slider.land(0, Vec3::Zero()));
  EXPECT_EQ(slider.descend(Vec3(0.1, 0.0, 0.1)), SurfaceNext::airborne);
}

// The length of the pull in the plane less mu_s times the depth is a convex function of time that begins below zero: it passes zero once.
TEST(SurfaceFriction, ItSlipsWhenThePullLeavesTheCone) {
  std::mt19937_64 random = make_random(5);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  int slipped_trials = 0;
  for (int trial = 0; trial < 500; ++trial) {
    const double mu = 0.05 + 1.5 * share(random);
    Slider slider(make_plane(), mu, 0.5 * mu);
    const Vec3 start(0.02 * share(random), 0.02 * share(random), 0.0);
    ASSERT_TRUE(slider.land(0, start));
    const double depth = 0.01 + 0.05 * share(random);
    const double angle = 2.0 * std::numbers::pi * share(random);
    const Vec3 from = start + 0.99 * mu * depth * share(random) * Vec3(std::cos(angle), std::sin(angle), 0.0) - Vec3(0, 0, depth);
    const Vec3 to = from + 0.05 * random_vector(random);
    if (!(to.z() < 0.0)) continue;
    ASSERT_EQ(slider.descend(from), SurfaceNext::settled);
    const auto out_of_cone = [&](double t) {
      const Vec3 pull = from + t * (to - from) - start;
      return in_plane(pull).norm() + mu * pull.z();
    };
    double time = 0.0;
    const SurfaceNext next = slider.friction.follow(slider.stage.point, from, to, time);
    if (!(out_of_cone(1.0) > 0.0)) {
      EXPECT_EQ(next, SurfaceNext::settled) << trial;
      EXPECT_EQ(time, 1.0);
      continue;
    }
    ++slipped_trials;
    ASSERT_EQ(next, SurfaceNext::descend) << trial;
    EXPECT_NEAR(time, find_slip_time(out_of_cone), 1e-10) << trial;
    EXPECT_EQ(slider.point(), start);
  }
  EXPECT_GT(slipped_trials, 200);
}

TEST(SurfaceFriction, OverAFaceItSlidesOnTheTractrix) {
  std::mt19937_64 random = make_random(7);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  int sliding_trials = 0;
  for (int trial = 0; trial < 500; ++trial) {
    const double mu = 0.05 + 0.8 * share(random);
    Slider slider(make_plane(), 1.5 * mu, mu);
    ASSERT_TRUE(slider.land(0, Vec3::Zero(), true));
    const double depth = 0.02 + 0.1 * share(random);
    const double end_depth = 0.02 + 0.1 * share(random);
    const double angle = 2.0 * std::numbers::pi * share(random);
    const Vec3 pull = mu * depth * Vec3(std::cos(angle), std::sin(angle), 0.0);
    const Vec3 from = pull - Vec3(0, 0, depth);
    const Vec3 motion = in_plane(0.1 * random_vector(random));
    if (!(pull.dot(motion) > 1.01 * pull.norm() * mu * (end_depth - depth))) continue;
    const SlidingPull sliding(pull, motion, mu * depth, mu * (end_depth - depth));
    bool slides_throughout = motion.norm() < 0.15;
    for (int i = 0; i <= 100; ++i) slides_throughout &= sliding.speed_at(0.01 * i) > 0.0;
    if (!slides_throughout) continue;
    ++sliding_trials;
    const Vec3 to = pull + motion - Vec3(0, 0, end_depth);
    ASSERT_EQ(slider.descend(from), SurfaceNext::settled);
    ASSERT_EQ(slider.follow(from, to), SurfaceNext::settled) << trial;
    EXPECT_LT((slider.point() - (pull + motion - sliding.at(1.0))).norm(), 1e-13) << trial;
    EXPECT_NEAR(in_plane(to - slider.point()).norm(), mu * end_depth, 1e-13);
    EXPECT_TRUE(slider.friction.slides());
  }
  EXPECT_GT(sliding_trials, 100);
}

// The point sticks, slips, slides and stops in turn, over any number of edges in the plane, as drag_by_friction computes it without edges.
TEST(SurfaceFriction, OverAPlaneItIsDraggedAsWithoutEdges) {
  std::mt19937_64 random = make_random(13);
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  for (const int cells : {1, 7, 40}) {
    int sliding_steps = 0, sticking_steps = 0, changes = 0;
    Slider slider(make_plane_grid(1.0, cells), 0.6, 0.4);
    const Vec3 start = slider.stage.middle(0);
    ASSERT_TRUE(slider.land(0, start));
    Vec3 device = start - Vec3(0, 0, 0.1);
    ASSERT_EQ(slider.descend(device), SurfaceNext::settled);
    FrictionDrag drag;
    for (int i = 0; i < 1000; ++i) {
      const double reach = i % 3 == 0 ? 0.3 : 0.05;
      const Vec3 aim(0.3 * share(random), 0.3 * share(random), -0.1 + 0.05 * share(random));
      const Vec3 to = device + reach * (aim - device);
      const FrictionDrag before = drag;
      drag = drag_by_friction({.pull = drag.pull,
                               .motion = in_plane(to - device),
                               .pressure_start = -device.z(),
                               .pressure_end = -to.z(),
                               .friction_static = 0.6,
                               .friction_dynamic = 0.4,
                               .sliding = drag.sliding});
      ASSERT_EQ(slider.follow(device, to), SurfaceNext::settled) << i;
      ASSERT_LT((in_plane(to) - slider.point() - drag.pull).norm(), 1e-10) << i;
      ASSERT_EQ(slider.friction.slides(), drag.sliding) << i;
      (drag.sliding ? sliding_steps : sticking_steps) += 1;
      changes += drag.sliding != before.sliding ? 1 : 0;
      device = to;
    }
    EXPECT_GT(sliding_steps, 100) << cells;
    EXPECT_GT(sticking_steps, 20) << cells;
    EXPECT_GT(changes, 20) << cells;
  }
}

// The device moves along x at depth 0.1, where the cones have radii of 0.06 and 0.03. If the pull stays above half of the dynamic cone, the
// point stops but still counts as sliding; below that, it sticks until the pull leaves the static cone.
TEST(SurfaceFriction, ItSticksAgainOnlyWhenThePullHasFallen) {
  for (const double eased_to : {1.01 * FrictionMotion::kRestick, 0.99 * FrictionMotion::kRestick}) {
    const bool sticks = eased_to < FrictionMotion::kRestick;
    Slider slider(make_plane(), 0.6, 0.3);
    ASSERT_TRUE(slider.land(0, Vec3::Zero()));
    const auto device = [](double x) { return Vec3(x, 0.0, -0.1); };
    ASSERT_EQ(slider.descend(device(0.07)), SurfaceNext::settled);
    const Vec3 expected(0.04, 0.0, 0.0);
    ASSERT_LT((slider.point() - expected).norm(), 1e-15);
    const Vec3 stopped = slider.point();
    ASSERT_EQ(slider.follow(device(0.07), device(0.04 + 0.03 * eased_to)), SurfaceNext::settled);
    EXPECT_EQ(slider.point(), stopped);
    EXPECT_EQ(slider.friction.slides(), !sticks);
    ASSERT_EQ(slider.follow(device(0.04 + 0.03 * eased_to), device(0.09)), SurfaceNext::settled);
    if (sticks) {
      EXPECT_EQ(slider.point(), stopped);
    } else {
      EXPECT_LT((slider.point() - Vec3(0.06, 0.0, 0.0)).norm(), 1e-13);
    }
    ASSERT_EQ(slider.follow(device(0.09), device(0.12)), SurfaceNext::settled);
    EXPECT_LT((slider.point() - Vec3(0.09, 0.0, 0.0)).norm(), 1e-13);  // beyond the static cone in either case
    EXPECT_TRUE(slider.friction.slides());
  }
}

TEST(SurfaceFriction, HeldFromTheStartItSlidesOnUnlessThePullHasFallen) {
  for (const double cone_share : {0.99, 1.01 * FrictionMotion::kRestick, 0.99 * FrictionMotion::kRestick, 0.0}) {
    Slider slider(make_plane(), 0.6, 0.3);
    ASSERT_TRUE(slider.land(0, Vec3::Zero(), true));
    ASSERT_EQ(slider.descend(Vec3(0.03 * cone_share, 0.0, -0.1)), SurfaceNext::settled);
    EXPECT_EQ(slider.point(), Vec3::Zero());
    EXPECT_EQ(slider.friction.slides(), cone_share > FrictionMotion::kRestick);
  }
}

// The device comes up through the face. By then the cone has shrunk to zero, so the point is where the device comes through.
TEST(SurfaceFriction, ItIsReleasedWhereTheDeviceComesThrough) {
  for (const bool slides : {false, true}) {
    Slider slider(make_plane(), 0.5, 0.4);
    ASSERT_TRUE(slider.land(0, Vec3::Zero(), slides));
    const Vec3 from(0.02, 0.01, -0.1);
    ASSERT_EQ(slider.descend(from), SurfaceNext::settled);
    double time = 0.0;
    ASSERT_EQ(slider.follow(from, Vec3(0.12, 0.01, 0.3), time), SurfaceNext::released);
    EXPECT_NEAR(time, 0.25, 1e-11);
    EXPECT_LT((slider.point() - Vec3(0.045, 0.01, 0.0)).norm(), 1e-11);
  }
}

// In a gutter along z, the bottom edge holds the point across the gutter; along the edge, friction acts, and the point moves straight.
TEST(SurfaceFriction, AlongAConcaveEdgeItStaysBehindByTheCone) {
  Slider slider(make_gutter(1.0, 0.3, 0.5 * std::numbers::pi, 3), 0.6, 0.4);
  const Vec3 bottom = slider.stage.local(0.0, 0.2, 0.05);
  std::uint32_t wall = slider.stage.count();
  int edge = 0;
  for (std::uint32_t t = 0; t < slider.stage.count(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const Vec3& a = slider.stage.geometry.corner(t, k);
      const Vec3& b = slider.stage.geometry.corner(t, (k + 1) % 3);
      if ((a - bottom).cross(b - bottom).norm() > 1e-12 || (a - bottom).dot(b - bottom) > 0.0) continue;
      wall = t;
      edge = k;
    }
  }
  ASSERT_TRUE(slider.stage.point.land_on_edge(wall, false, edge, bottom));
  ASSERT_FALSE(slider.stage.point.is_convex());
  slider.friction.begin(slider.stage.point.material(), false);
  const auto device = [&](double down, double along) { return Vec3(bottom + Vec3(0.0, -down, along)); };
  ASSERT_EQ(slider.descend(device(0.1, 0.0)), SurfaceNext::settled);
  ASSERT_EQ(slider.follow(device(0.1, 0.0), device(0.1, 0.0599)), SurfaceNext::settled);
  EXPECT_EQ(slider.point(), bottom);  // inside the static cone
  double time = 0.0;
  ASSERT_EQ(slider.friction.follow(slider.stage.point, device(0.1, 0.0599), device(0.1, 0.0699), time), SurfaceNext::descend);
  EXPECT_NEAR(time, 0.01, 1e-9);
  ASSERT_EQ(slider.descend(on_path(device(0.1, 0.0599), device(0.1, 0.0699), time)), SurfaceNext::settled);
  EXPECT_LT((slider.point() - bottom - Vec3(0, 0, 0.02)).norm(), 1e-10);
  EXPECT_TRUE(slider.friction.slides());
  // The point passes the vertices along the bottom while the depth changes: its distance behind the device is in proportion to the depth.
  Vec3 from = on_path(device(0.1, 0.0599), device(0.1, 0.0699), time);
  for (const auto& [down, along] : {std::pair{0.1, 0.1}, {0.15, 0.2}, {0.05, 0.25}, {0.1, 0.4}}) {
    const Vec3 to = device(down, along);
    ASSERT_EQ(slider.follow(from, to), SurfaceNext::settled);
    EXPECT_LT((slider.point() - bottom - Vec3(0, 0, along - 0.4 * down)).norm(), 1e-10) << along;
    from = to;
  }
  // The depth grows faster than the pull: the point stays.
  const Vec3 before = slider.point();
  ASSERT_EQ(slider.follow(from, device(0.2, 0.41)), SurfaceNext::settled);
  EXPECT_EQ(slider.point(), before);
}

// The point comes down one wall to the bottom of a gutter, stays there, and is then pulled up the same wall again. (mountain_51k_open,
// slide of seed 3, row 849: the point once stayed at the bottom forever.)
TEST(SurfaceFriction, HeldAtAConcaveEdgeItGoesBackOverItsEntryFace) {
  Slider slider(make_gutter(1.0, 0.3, 0.5 * std::numbers::pi, 3), 0.6, 0.4);
  const Vec3 bottom = slider.stage.local(0.0, 0.2, 0.05);
  const Vec3 start = bottom + Vec3(-0.05, 0.05, 0.0);
  bool landed = false;
  for (std::uint32_t t = 0; t < slider.stage.count() && !landed; ++t) {
    const Separation at = slider.stage.geometry.separation(t, start);
    landed = at.distance < 1e-12 && at.feature == Feature::face && slider.land(t, start);
  }
  ASSERT_TRUE(landed);
  const auto device = [&](double left) { return Vec3(bottom + Vec3(-left, -0.1, 0.0)); };
  ASSERT_EQ(slider.descend(device(-0.02)), SurfaceNext::settled);
  EXPECT_LT((slider.point() - bottom).norm(), 1e-12);
  // Along the left wall the pull is left - 0.1 and the depth left + 0.1, both over sqrt(2): the pull leaves the cone at left = 0.4.
  ASSERT_EQ(slider.follow(device(-0.02), device(0.399)), SurfaceNext::settled);
  EXPECT_LT((slider.point() - bottom).norm(), 1e-12);
  double time = 0.0;
  ASSERT_EQ(slider.friction.follow(slider.stage.point, device(0.399), device(0.409), time), SurfaceNext::descend);
  EXPECT_NEAR(time, 0.1, 1e-6);
  ASSERT_EQ(slider.descend(on_path(device(0.399), device(0.409), time)), SurfaceNext::settled);
  EXPECT_LT((slider.point() - bottom - Vec3(-0.05, 0.05, 0.0)).norm(), 1e-6);  // mu_d depth behind: (0.3 - 0.4 * 0.5) / 2
}

// The bottom of a pit with walls of slope 1.25. With the device below it, the point stays while friction holds it against the steepest
// direction upwards; the device moves outwards below the concave edge between two walls.
TEST(SurfaceFriction, AtTheBottomOfAPitItStaysUntilThePullLeavesTheCone) {
  Slider slider(make_pit(1.0, 0.5), 0.4, 0.2);
  SurfacePoint& point = slider.stage.point;
  const Vec3 bottom = slider.stage.local(0, 0, 0);
  ASSERT_TRUE(slider.stage.stand_at_vertex(bottom));
  slider.friction.begin(point.material(), false);
  const Vec3 from = bottom + Vec3(0.1, 0.1, -0.16);
  ASSERT_EQ(slider.descend(from), SurfaceNext::settled);
  ASSERT_EQ(point.on(), SurfacePoint::On::vertex);
  const Vec3 to = from + Vec3(0.2, 0.2, 0.0);
  const auto out_of_cone = [&](double t) {
    const Vec3 pull = from + t * (to - from) - bottom;
    const SurfacePoint::Descent way = point.find_steepest(pull, 0.0);
    return way.facet == nullptr ? -1.0 : way.length - 0.4 * std::sqrt(pull.squaredNorm() - way.length * way.length);
  };
  const double slip_time = find_slip_time(out_of_cone);
  ASSERT_GT(slip_time, 0.1);
  ASSERT_LT(slip_time, 0.9);
  EXPECT_EQ(slider.follow(from, on_path(from, to, 0.999 * slip_time)), SurfaceNext::settled);
  EXPECT_EQ(point.point(), bottom);
  EXPECT_EQ(point.on(), SurfacePoint::On::vertex);
  double time = 0.0;
  EXPECT_EQ(slider.friction.follow(point, from, to, time), SurfaceNext::descend);
  EXPECT_NEAR(time, slip_time, 1e-9);
  ASSERT_EQ(slider.descend(on_path(from, to, time)), SurfaceNext::settled);
  EXPECT_GT((point.point() - bottom).norm(), 1e-3);
  EXPECT_TRUE(slider.friction.slides());
}

// With the device straight below a concave vertex or edge, the pull is outside the friction cone of each wall, on the side that points down
// the wall: it must pass through the inside of that cone before the point slips up the wall.
TEST(SurfaceFriction, ItSlipsUpAWallThatThePullFirstPointsDown) {
  std::mt19937_64 random = make_random(17);
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  int slipped_trials = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const double mu = 0.45 + 0.35 * share(random);
    Slider slider(make_pit(1.0, 0.5), mu, 0.5 * mu);
    SurfacePoint& point = slider.stage.point;
    const Vec3 bottom = slider.stage.local(0, 0, 0);
    ASSERT_TRUE(slider.stage.stand_at_vertex(bottom));
    slider.friction.begin(point.material(), false);
    const Vec3 from = bottom + Vec3(0.02 * share(random), 0.02 * share(random), -0.1);
    const Vec3 to = from + Vec3(0.3 * share(random), 0.3 * share(random), 0.03 * share(random));
    ASSERT_EQ(slider.descend(from), SurfaceNext::settled);
    ASSERT_EQ(point.on(), SurfacePoint::On::vertex);
    const auto out_of_cone = [&](double t) {
      const Vec3 pull = from + t * (to - from) - bottom;
      const SurfacePoint::Descent way = point.find_steepest(pull, 0.0);
      return way.facet == nullptr ? -1.0 : way.length - mu * std::sqrt(pull.squaredNorm() - way.length * way.length);
    };
    if (!(out_of_cone(1.0) > 0.0)) continue;
    ++slipped_trials;
    const double slip_time = find_slip_time(out_of_cone);
    double time = 0.0;
    ASSERT_EQ(slider.friction.follow(point, from, to, time), SurfaceNext::descend) << trial;
    EXPECT_NEAR(time, slip_time, 1e-9) << trial;
    EXPECT_EQ(point.point(), bottom);
  }
  EXPECT_GT(slipped_trials, 50);
}

}  // namespace
}  // namespace hapton
