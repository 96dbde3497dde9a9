// Corners between bodies that can be carved and other objects: one proxy touches both.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "core/force/touch_step.h"
#include "core/geometry/mesh_shapes.h"
#include "core/math/types.h"

namespace hapton {
namespace {

constexpr double kVoxel = 0.001;
constexpr SculptSettings kCornerClay{.voxel_m = kVoxel, .tool_radius_m = 0.004, .button = 1};

TouchObject corner_box(const Vec3& size, const Pose& pose, double stiffness_n_per_m = 800.0) {
  TriangleMesh mesh = make_box(size);
  for (Vec3& vertex : mesh.vertices) vertex = pose * vertex;
  return {.mesh = std::make_shared<const TriangleMesh>(std::move(mesh)), .material = {.stiffness_n_per_m = stiffness_n_per_m}};
}

// Clay whose top is z = 0, with a wall on it at the given angle to the top, its foot sunk into the clay. The wall's face goes through the y
// axis, and the probe is at x > 0.
TouchScene clay_with_wall(double angle_deg, double sunk_m = 0.005, bool wall_moves = false) {
  TouchObject clay = corner_box(Vec3(0.06, 0.04, 0.02), Pose(Eigen::Translation3d(0.0, 0.0, -0.01)));
  clay.sculpt = kCornerClay;
  const Eigen::AngleAxisd turn((90.0 - angle_deg) * M_PI / 180.0, Vec3::UnitY());
  const double height = 0.03 + sunk_m;
  TouchObject wall = corner_box(Vec3(0.01, 0.08, height), turn * Pose(Eigen::Translation3d(-0.005, 0.0, 0.5 * height - sunk_m)));
  if (wall_moves) wall.command_pivot = Vec3::Zero();
  return {.objects = {wall, clay}};
}

std::unique_ptr<TouchStep> touch_of(const TouchScene& scene, const char* method = "proxy") {
  auto made = make_method({.name = method}, scene);
  EXPECT_TRUE(made) << made.error().what;
  return std::make_unique<TouchStep>(std::shared_ptr<ForceMethod>(std::move(*made)), scene);
}

// The height of the ball's centre while it lies on the top of the clay.
double resting_height(TouchStep& touch) {
  touch.reset({.p_WD = {0.02, 0, 0.02}});
  TouchOutput felt;
  for (int i = 0; i < 20; ++i) felt = touch.step({.p_WD = {0.02, 0.0, 0.003}, .dt_s = 1e-3});
  return 0.003 + felt.visual_offset_m.z();
}

// The point q nearest to p with wall_normal.dot(q) >= 0 (the wall) and q.z() >= top (the clay).
Vec3 nearest_in_corner(const Vec3& p, const Vec3& wall_normal, double top) {
  // One of the two planes holds the point alone, or both do.
  const Vec3 on_top(p.x(), p.y(), std::max(p.z(), top));
  if (wall_normal.dot(on_top) >= 0.0) return on_top;
  const Vec3 on_wall = p - std::min(0.0, wall_normal.dot(p)) * wall_normal;
  if (on_wall.z() >= top) return on_wall;
  return {-wall_normal.z() * top / wall_normal.x(), p.y(), top};
}

struct CornerCase {
  double angle_deg;
  bool wall_moves;
};

class SculptCorner : public testing::TestWithParam<CornerCase> {};

// A hand that circles in the corner is pushed by stiffness times the way to the nearest free point, and gains no energy.
TEST_P(SculptCorner, HasTheForceOfOneProxyAndNoEnergy) {
  const auto [angle_deg, wall_moves] = GetParam();
  const auto touch = touch_of(clay_with_wall(angle_deg, 0.005, wall_moves));
  const double top = resting_height(*touch);
  const double angle = angle_deg * M_PI / 180.0;
  const Vec3 wall_normal(std::sin(angle), 0.0, -std::cos(angle));  // out of the wall
  const Vec3 corner(-wall_normal.z() * top / wall_normal.x(), 0.0, top);
  const auto hand_at = [&](int i) {
    const double phi = 2.0 * M_PI * i / 2000.0;
    return Vec3(corner + 0.004 * Vec3(std::cos(phi), 0.1 * std::sin(phi), std::sin(phi)));
  };
  touch->reset({.p_WD = corner + Vec3(0.02, 0, 0.002)});
  double energy_j = 0.0, largest_n = 0.0, jump_n = 0.0;
  Vec3 before_n = Vec3::Zero();
  for (int i = 0; i <= 6000; ++i) {
    const TouchOutput felt = touch->step({.p_WD = hand_at(i), .dt_s = 1e-3});
    if (i >= 2000) {
      energy_j += 0.5 * (felt.force_n + before_n).dot(hand_at(i) - hand_at(i - 1));
      jump_n = std::max(jump_n, (felt.force_n - before_n).norm());
      const Vec3 expected = 800.0 * (nearest_in_corner(hand_at(i), wall_normal, top) - hand_at(i));
      ASSERT_LT((felt.force_n - expected).norm(), 0.012 * 800.0 * kVoxel) << "step " << i << ", " << expected.transpose();
    }
    before_n = felt.force_n;
    largest_n = std::max(largest_n, felt.force_n.norm());
  }
  EXPECT_GT(largest_n, 2.5);
  EXPECT_LT(std::abs(energy_j), 2e-6) << "J in two turns";
  EXPECT_LT(jump_n, 1.2 * 800.0 * 0.004 * 2.0 * M_PI / 2000.0 / std::sin(std::min(angle, M_PI / 2)) + 0.005);
}

INSTANTIATE_TEST_SUITE_P(Angles, SculptCorner,
                         testing::Values(CornerCase{60, false}, CornerCase{90, false}, CornerCase{120, false}, CornerCase{150, false},
                                         CornerCase{60, true}, CornerCase{90, true}, CornerCase{120, true}, CornerCase{150, true}),
                         [](const auto& test) {
                           return std::to_string(static_cast<int>(test.param.angle_deg)) + (test.param.wall_moves ? "Commanded" : "Still");
                         });

// A hand is pressed against the wall and into the clay, then lifted along the wall: nothing pulls it down, and the probe stays out of the
// wall, however deep the foot of the wall is in the clay.
TEST(SculptCorner, AHandLiftedAlongAWallIsFree) {
  for (const double sunk_m : {0.0, 1e-4, 1e-3, 5e-3}) {
    for (const bool wall_moves : {false, true}) {
      const auto touch = touch_of(clay_with_wall(90.0, sunk_m, wall_moves));
      touch->reset({.p_WD = {0.01, 0, 0.02}});
      Vec3 before_n = Vec3::Zero();
      for (int i = 0; i <= 4000; ++i) {
        const double time_s = 1e-3 * i;
        // Down beside the wall, 6 mm deep; into the wall, 5 mm deep; up along it.
        const double x = time_s < 1.0 ? 0.004 : std::max(-0.005, 0.004 - 0.009 * (time_s - 1.0));
        const double z = time_s < 2.0 ? std::max(-0.003, 0.015 - 0.018 * time_s) : -0.003 + 0.012 * (time_s - 2.0);
        const TouchOutput felt = touch->step({.p_WD = {x, 0.001, z}, .dt_s = 1e-3});
        const Vec3 proxy = Vec3(x, 0.001, z) + felt.visual_offset_m;
        ASSERT_GT(proxy.x(), -1e-6) << "in the wall: foot " << sunk_m << ", at " << time_s << " s";
        ASSERT_GT(felt.force_n.z(), -1e-3) << "pulled down: foot " << sunk_m << ", at " << time_s << " s";
        ASSERT_LT((felt.force_n - before_n).norm(), 0.06) << "foot " << sunk_m << ", at " << time_s << " s";
        before_n = felt.force_n;
      }
      EXPECT_NEAR(before_n.x(), 800.0 * 0.005, 0.01);
      EXPECT_NEAR(before_n.z(), 0.0, 1e-3);
    }
  }
}

// In one sample the hand goes past the edge of the clay that is behind the wall: the ball stays on top of the clay, because the wall does
// not let it through.
TEST(SculptCorner, AJumpPastAnEdgeBehindTheWallIsHeldOnThisSide) {
  for (const bool wall_moves : {false, true}) {
    TouchScene scene = clay_with_wall(90.0, 0.005, wall_moves);
    scene.objects[1] = corner_box(Vec3(0.04, 0.04, 0.02), Pose(Eigen::Translation3d(0.019, 0.0, -0.01)));
    scene.objects[1].sculpt = kCornerClay;
    const auto touch = touch_of(scene);
    const double top = resting_height(*touch);
    touch->reset({.p_WD = {0.004, 0, 0.005}});
    for (int i = 0; i < 10; ++i) touch->step({.p_WD = {0.004, 0, 0.005}, .dt_s = 1e-3});
    TouchOutput felt;
    for (int i = 0; i < 5; ++i) felt = touch->step({.p_WD = {-0.006, 0, -0.003}, .dt_s = 1e-3});
    EXPECT_NEAR(felt.force_n.x(), 800.0 * 0.006, 0.02);
    EXPECT_NEAR(felt.force_n.z(), 800.0 * (top + 0.003), 0.3) << "voxels round the edge";
  }
}

// While the ball also touches a wall, the damping of the clay acts once, on the motion of the hand.
TEST(SculptCorner, DampsOnce) {
  for (const double damping : {0.0, 5.0}) {
    TouchScene scene = clay_with_wall(90.0);
    scene.objects[1].material.damping_ns_per_m = damping;
    const auto touch = touch_of(scene);
    const double top = resting_height(*touch);
    touch->reset({.p_WD = {0.004, 0, 0.005}});
    for (int i = 0; i < 250; ++i) {
      const double time_s = 1e-3 * i;
      const double x = std::max(-0.002, 0.004 - 0.1 * time_s), z = 0.005 - 0.02 * time_s;
      const TouchOutput felt = touch->step({.p_WD = {x, 0, z}, .dt_s = 1e-3});
      if (i < 150) continue;
      ASSERT_NEAR(felt.force_n.x(), 800.0 * 0.002, 0.01) << i;
      ASSERT_NEAR(felt.force_n.z(), 800.0 * (top - z) + damping * 0.02, 0.015) << i;
    }
  }
}

// A groove is cut along the foot of the wall: the ball sinks into the clay, never into the wall, and the force never changes faster than
// the lag of the cut permits, even when the button is pressed or released.
TEST(SculptCorner, CutsAlongAWallWithoutEnteringIt) {
  for (const double angle_deg : {60.0, 90.0, 120.0}) {
    for (const double wall_stiffness : {400.0, 800.0, 1600.0}) {
      TouchScene scene = clay_with_wall(angle_deg, 0.015);
      scene.objects[0].material.stiffness_n_per_m = wall_stiffness;
      const auto touch = touch_of(scene);
      const double angle = angle_deg * M_PI / 180.0;
      const Vec3 wall_normal(std::sin(angle), 0.0, -std::cos(angle));
      touch->reset({.p_WD = {0.02, -0.01, 0.006}});
      Vec3 before_n = Vec3::Zero();
      double lowest = 1.0;
      for (int i = 0; i <= 6000; ++i) {
        const double time_s = 1e-3 * i;
        const double z = time_s < 1.0 ? 0.006 - 0.0027 * time_s : 0.0033 - 0.004 * std::min(1.0, time_s - 1.0);
        const double on_wall = z / std::tan(angle);
        const Vec3 hand(on_wall + 0.005 - 0.008 * std::min(1.0, time_s), -0.01 + 0.02 * std::clamp((time_s - 2.0) / 3.0, 0.0, 1.0), z);
        const bool is_down = time_s > 1.2 && time_s < 5.5;
        const TouchOutput felt = touch->step({.p_WD = hand, .dt_s = 1e-3, .buttons = is_down ? 1U : 0U});
        const Vec3 proxy = hand + felt.visual_offset_m;
        ASSERT_GT(wall_normal.dot(proxy), -1e-6) << angle_deg << " degrees, at " << time_s << " s";
        lowest = std::min(lowest, proxy.z());
        ASSERT_LT((felt.force_n - before_n).norm(), 0.06 * before_n.norm() + 0.03) << angle_deg << " degrees, at " << time_s << " s";
        before_n = felt.force_n;
      }
      EXPECT_LT(lowest, 0.0015) << "it was cut";
      EXPECT_GT(touch->method().sculpture()->newest(), 20U);
    }
  }
}

// A cut between a wall that programs may move and a table: what clay, wall and table hold adds up to the extension, at any angle.
TEST(SculptCorner, CutsBetweenAWallAndATableWithoutAJump) {
  for (const double angle_deg : {60.0, 80.0, 90.0, 110.0}) {
    TouchScene scene = clay_with_wall(angle_deg, 0.025, true);
    scene.objects.push_back(corner_box(Vec3(0.2, 0.2, 0.02), Pose(Eigen::Translation3d(0.0, 0.0, -0.016))));
    const auto touch = touch_of(scene);
    const double on_wall = -0.006 / std::tan(angle_deg * M_PI / 180.0);
    touch->reset({.p_WD = {0.012, -0.01, 0.006}});
    Vec3 before_n = Vec3::Zero();
    int steps_at_both = 0;
    for (int i = 0; i <= 6000; ++i) {
      const double time_s = 1e-3 * i;
      const Vec3 hand(0.012 + (on_wall - 0.015) * std::clamp(time_s - 1.0, 0.0, 1.0),
                      -0.01 + 0.02 * std::clamp((time_s - 2.0) / 3.0, 0.0, 1.0), 0.006 - 0.015 * std::min(1.0, time_s));
      const TouchOutput felt = touch->step({.p_WD = hand, .dt_s = 1e-3, .buttons = time_s < 5.5 ? 1U : 0U});
      const Vec3 proxy = hand + felt.visual_offset_m;
      steps_at_both += proxy.z() < -0.0059 && felt.visual_offset_m.x() > 1e-4 ? 1 : 0;
      ASSERT_LT((felt.force_n - 800.0 * felt.visual_offset_m).norm(), 1e-3) << angle_deg << " degrees, at " << time_s << " s";
      ASSERT_LT((felt.force_n - before_n).norm(), 0.06 * before_n.norm() + 0.05) << angle_deg << " degrees, at " << time_s << " s";
      before_n = felt.force_n;
    }
    EXPECT_GT(steps_at_both, 1000) << angle_deg << " degrees";
  }
}

// A hand moves at random and presses the button now and then, where a wall, which programs may move in some cases, stands in the clay.
// The proxy is never in the wall by more than 1e-7 m, also with friction of the clay, and no force exceeds that of the spring and the
// damping.
TEST(SculptCorner, ARandomHandNeverEntersTheWall) {
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    for (const auto& [wall_moves, friction] : {std::pair(false, 0.0), {true, 0.0}, {false, 0.5}, {true, 0.5}}) {
      TouchScene scene = clay_with_wall(90.0, 0.015, wall_moves);
      scene.objects[0].material.damping_ns_per_m = 1.0;
      scene.objects[1].material.friction_static = friction;
      scene.objects[1].material.friction_dynamic = 0.6 * friction;
      double deepest_m = 0.0;
      const auto touch = touch_of(scene);
      std::mt19937_64 random(seed);
      std::normal_distribution<double> push(0.0, 1.0);
      Vec3 p(0.01, 0, 0.01), v = Vec3::Zero();
      touch->reset({.p_WD = p});
      int wall_steps = 0;
      for (int i = 0; i < 6000; ++i) {
        v = 0.98 * v + 4e-6 * Vec3(push(random), push(random), push(random)) - 4e-5 * (p - Vec3(0.0, 0.0, 0.002));
        p += v;
        const TouchOutput felt = touch->step({.p_WD = p, .dt_s = 1e-3, .buttons = (i / 400) % 2 == 0 ? 0U : 1U});
        const Vec3 proxy = p + felt.visual_offset_m;
        // The depth counts from either side of the wall.
        const bool is_in_wall = proxy.z() < 0.03 && proxy.z() > -0.015;
        if (is_in_wall) deepest_m = std::max(deepest_m, std::min(-proxy.x(), proxy.x() + 0.01));
        ASSERT_TRUE(felt.force_n.allFinite());
        ASSERT_LT(felt.force_n.norm(), 800.0 * 1.01 * felt.visual_offset_m.norm() + 2.0 * (v.norm() / 1e-3) + 1e-9);
        wall_steps += felt.contact && felt.object == 0 ? 1 : 0;
      }
      EXPECT_GT(wall_steps, 100) << "seed " << seed;
      EXPECT_LT(deepest_m, 1e-7) << "seed " << seed << ", friction " << friction << (wall_moves ? ", commanded" : "");
    }
  }
}

}  // namespace
}  // namespace hapton
