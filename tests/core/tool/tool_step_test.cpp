#include "core/tool/tool_step.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <random>

#include "core/collision/triangle_pair.h"
#include "core/geometry/mesh_shapes.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/thread_team.h"

namespace hapton {
namespace {

std::unique_ptr<ToolStep> make_step(const TriangleMesh& tool, const TriangleMesh& scene, const ToolCoupling& coupling = {}) {
  auto made = ToolStep::make(tool, {std::make_shared<TriangleMesh>(scene)}, coupling);
  EXPECT_TRUE(made) << made.error().what;
  return std::move(*made);
}

Pose pose_at(const Vec3& p, const Vec3& turn = Vec3::Zero()) {
  Pose X = Pose::Identity();
  X.translation() = p;
  X.linear() = turn_by(turn).toRotationMatrix();
  return X;
}

// Tests exactly whether any two triangles of tool and scene intersect.
bool penetrates(const ToolStep& step) {
  const Placement& at = step.proxy().placement();
  for (std::uint32_t t = 0; t < step.tool().triangle_count(); ++t) {
    for (std::uint32_t s = 0; s < step.scene().triangle_count(); ++s) {
      const ObjectGeometry::Corners c = step.scene().corners(s);
      const TrianglePair pair = {{at.at(step.tool().corner(t, 0)), at.at(step.tool().corner(t, 1)), at.at(step.tool().corner(t, 2))},
                                 {c.a, c.b, c.c}};
      if (intersect_triangles(pair).meets) return true;
    }
  }
  return false;
}

constexpr double kDefaultStiffness = 1000.0;  // N/m, of ToolCoupling

TEST(ToolStep, ABoxPressedFlatOnAPlaneGivesTheForceOfItsDepth) {
  const auto step = make_step(make_box({0.02, 0.02, 0.02}), make_plane_grid(0.2, 8));
  step->reset({pose_at({0.003, 0.004, 0.03})});
  ToolOutput out;
  for (int n = 0; n <= 250; ++n) out = step->step({pose_at({0.003, 0.004, 0.03 - 0.0001 * n})});
  // The device is 5 mm above the plane: without contact the box's lower face would be 5 mm below it.
  EXPECT_TRUE(out.contact);
  EXPECT_NEAR(out.force_n.z(), kDefaultStiffness * 0.005, 2e-3);
  EXPECT_NEAR(out.force_n.head<2>().norm(), 0.0, 2e-3);
  EXPECT_NEAR(out.torque_nm.norm(), 0.0, 2e-5);
  EXPECT_GE(out.proxy.haptons, 3);
  EXPECT_TRUE(out.proxy.converged);
  EXPECT_FALSE(penetrates(*step));
}

TEST(ToolStep, FreeSpaceGivesNothingAtAll) {
  const auto step = make_step(make_box({0.02, 0.02, 0.02}), make_plane_grid(0.2, 8));
  step->reset({pose_at({0.0, 0.0, 0.03})});
  for (int n = 0; n < 100; ++n) {
    const Pose X = pose_at({0.0001 * n, 0.0, 0.03}, {0.01 * n, 0.02 * n, 0.0});
    const ToolOutput out = step->step({X});
    ASSERT_EQ(out.force_n.norm(), 0.0);
    ASSERT_EQ(out.torque_nm.norm(), 0.0);
    ASSERT_TRUE(out.X_WP.isApprox(X, 0.0));
    ASSERT_FALSE(out.contact);
  }
}

// With a high rotational stiffness, the turn that belongs to a torque is far smaller than the accuracy with which shifts are followed.
TEST(ToolStep, ACornerOnAPlaneHasTheTorqueOfItsForceHoweverStiffTheTurn) {
  const TriangleMesh box = make_box({0.02, 0.02, 0.02});
  for (const double nm_per_rad : {3.0, 300.0, 1e4, 1e5}) {
    const auto step = make_step(box, make_plane_grid(0.2, 8), {.rotational_stiffness_nm_per_rad = nm_per_rad});
    const Vec3 tilt(0.3, 0.2, 0.0);
    step->reset({pose_at({0.0, 0.0, 0.03}, tilt)});
    ToolOutput out;
    for (int n = 0; n <= 250; ++n) out = step->step({pose_at({0.0, 0.0, 0.03 - 0.0001 * n}, tilt)});
    Vec3 lowest = Vec3::Zero();
    for (const Vec3& v : box.vertices) {
      const Vec3 arm = out.X_WP.linear() * v;
      if (arm.z() < lowest.z()) lowest = arm;
    }
    const Vec3 expected = lowest.cross(out.force_n);
    ASSERT_GT(expected.norm(), 0.05);
    EXPECT_LT((out.torque_nm - expected).norm(), 0.01 * expected.norm()) << nm_per_rad << " Nm/rad";
    EXPECT_FALSE(penetrates(*step));
  }
}

// A frictionless contact pushes along its normal: on a plane the force is vertical, and its torque about the grip point is that of a force
// at the box's lowest edge.
TEST(ToolStep, ATiltedBoxOnItsEdgeBalancesForceAndTorque) {
  const auto step = make_step(make_box({0.02, 0.02, 0.02}), make_plane_grid(0.2, 8));
  step->reset({pose_at({0.0, 0.0, 0.03}, {0.0, 0.3, 0.0})});
  ToolOutput out;
  for (int n = 0; n <= 200; ++n) out = step->step({pose_at({0.0, 0.0, 0.03 - 0.0001 * n}, {0.0, 0.3, 0.0})});
  ASSERT_TRUE(out.contact);
  EXPECT_NEAR(out.force_n.x(), 0.0, 1e-3);
  EXPECT_GT(out.force_n.z(), 1.0);
  // The lowest corner of the proxy, in the plane of the motion.
  Vec3 lowest = Vec3::Zero();
  for (const double x : {-0.01, 0.01}) {
    const Vec3 arm = out.X_WP.linear() * Vec3(x, 0.0, -0.01);
    if (arm.z() < lowest.z()) lowest = arm;
  }
  const Vec3 torque = lowest.cross(out.force_n);
  EXPECT_NEAR(out.torque_nm.y(), torque.y(), 0.01 * torque.norm());
  EXPECT_FALSE(penetrates(*step));
}

TEST(ToolStep, APegStaysInItsHole) {
  // A square hole with 20 um of clearance on each side; its walls are four blocks.
  constexpr double kSide = 0.01;
  constexpr double kClearance = 20e-6;
  TriangleMesh walls;
  const double wall_distance = 0.5 * kSide + kClearance + 0.01;
  for (const double side : {-1.0, 1.0}) {
    walls = joined(walls, scaled_and_moved(make_box({0.02, 0.05, 0.02}, 3), 1.0, {side * wall_distance, 0.0, 0.0}));
    walls = joined(walls, scaled_and_moved(make_box({kSide + 2.0 * kClearance, 0.02, 0.02}, 3), 1.0, {0.0, side * wall_distance, 0.0}));
  }
  const auto step = make_step(make_box({kSide, kSide, 0.03}, 2), walls);
  step->reset({pose_at({0.0, 0.0, 0.03})});
  int blocked_steps = 0;
  double largest_n = 0.0;
  for (int n = 0; n < 3000; ++n) {
    const double t = 0.001 * n;
    const Pose X = pose_at({0.002 * std::sin(7.0 * t), 0.001 * std::cos(5.0 * t), 0.03 * std::cos(1.5 * t)},
                           {0.05 * std::sin(9.0 * t), 0.04 * std::sin(11.0 * t), 0.06 * std::sin(6.0 * t)});
    const ToolOutput out = step->step({X});
    blocked_steps += out.proxy.is_blocked ? 1 : 0;
    largest_n = std::max(largest_n, out.force_n.norm());
    if (n % 50 == 0) {
      ASSERT_FALSE(penetrates(*step)) << "step " << n;
    }
  }
  EXPECT_EQ(blocked_steps, 0);
  EXPECT_GT(largest_n, 0.5);
}

TEST(ToolStep, UsesNoHeap) {
  const auto step = make_step(make_icosphere(0.01, 2), make_bumpy_sphere(0.05, 0.1, 5000, 1));
  step->reset({pose_at({0.0, 0.0, 0.08})});
  std::uint64_t count = 0;
  for (int n = 0; n < 300; ++n) {
    const Pose X = pose_at({0.0, 0.00005 * n, 0.08 - 0.0001 * n}, {0.0, 0.01 * n, 0.0});
    const AllocationGuard guard;
    step->step({X});
    count += guard.count();
  }
  if (!AllocationGuard::is_available()) GTEST_SKIP();
  EXPECT_EQ(count, 0U);
}

// Force, torque and pose are the same to the bit with any number of workers, in motions that slide, turn and press.
TEST(ToolStep, WorkersChangeNothingButTheTime) {
  const TriangleMesh scene = make_bumpy_sphere(0.05, 0.1, 1200, 3);
  const TriangleMesh tool = make_bumpy_sphere(0.01, 0.1, 300, 5);
  const auto step_of_one = make_step(tool, scene);
  for (const int workers : {2, 5}) {
    auto made = ToolStep::make(tool, {std::make_shared<TriangleMesh>(scene)}, {}, {}, std::make_unique<made::ThreadTeam>(workers));
    ASSERT_TRUE(made);
    ToolStep& step_of_team = **made;
    int steps_in_contact = 0;
    for (int n = 0; n < 400; ++n) {
      const double angle = 0.004 * n;
      const Vec3 direction(std::cos(angle), std::sin(angle), 0.2 * std::sin(3.0 * angle));
      const ToolInput input{pose_at((n == 0 ? 0.09 : 0.056) * direction, Vec3(2.0 * angle, -angle, 0.0))};
      if (n == 0) {
        step_of_one->reset(input);
        step_of_team.reset(input);
      }
      const ToolOutput expected = step_of_one->step(input);
      const ToolOutput output = step_of_team.step(input);
      ASSERT_EQ(output.force_n, expected.force_n) << "step " << n << ", " << workers << " workers";
      ASSERT_EQ(output.torque_nm, expected.torque_nm);
      ASSERT_EQ(output.X_WP.matrix(), expected.X_WP.matrix());
      ASSERT_EQ(output.proxy.feature_count, expected.proxy.feature_count);
      steps_in_contact += expected.contact ? 1 : 0;
    }
    EXPECT_GT(steps_in_contact, 300);
  }
}

}  // namespace
}  // namespace hapton
