#include "core/tool/tool_friction.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/geometry/mesh_shapes.h"
#include "core/tool/held_tool.h"
#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

constexpr double kRubK = 1000.0;
constexpr double kDepth = 0.002;
constexpr CoulombFriction kRough = {0.5, 0.3};

std::unique_ptr<ToolStep> make_rough_step(const TriangleMesh& scene, const CoulombFriction& friction) {
  auto made =
      ToolStep::make(make_box({0.02, 0.02, 0.02}), {std::make_shared<TriangleMesh>(scene)}, {.stiffness_n_per_m = kRubK}, {friction});
  EXPECT_TRUE(made) << made.error().what;
  return std::move(*made);
}

ToolInput rub_at(const Vec3& p, double turn_rad = 0.0) {
  ToolInput input;
  input.X_WD.translation() = p;
  input.X_WD.linear() = turn_by({0.0, 0.0, turn_rad}).toRotationMatrix();
  return input;
}

// Down on a plane, so that 2 N press it.
void press(ToolStep& step) {
  step.reset(rub_at({0.003, 0.004, 0.03}));
  for (int n = 0; n <= 220; ++n) step.step(rub_at({0.003, 0.004, 0.03 - 0.0001 * n}));
}

TEST(ToolFriction, ABoxSticksUpToTheStaticLimitAndThenLagsByTheDynamicOne) {
  const auto step = make_rough_step(make_plane_grid(0.2, 8), kRough);
  press(*step);
  const double normal_n = kRubK * kDepth;
  double most_n = 0.0;
  double x = 0.003;
  ToolOutput out;
  for (int n = 0; n < 60; ++n, x += 2e-5) {
    out = step->step(rub_at({x, 0.004, 0.008}));
    most_n = std::max(most_n, std::abs(out.force_n.x()));
  }
  EXPECT_NEAR(most_n, kRough.friction_static * normal_n, kRubK * 2e-5 + 1e-3);
  EXPECT_NEAR(out.force_n.x(), -kRough.friction_dynamic * normal_n, 2e-3);
  EXPECT_NEAR(out.force_n.z(), normal_n, 2e-3);
  EXPECT_NEAR(out.force_n.y(), 0.0, 1e-3);
  // Back: it sticks until the pull has turned round.
  for (int n = 0; n < 20; ++n, x -= 2e-5) out = step->step(rub_at({x, 0.004, 0.008}));
  EXPECT_NEAR(out.force_n.x(), -kRough.friction_dynamic * normal_n + kRubK * 20 * 2e-5, kRubK * 4e-5 + 2e-3);
}

TEST(ToolFriction, ARestingToolDoesNotCreep) {
  const auto step = make_rough_step(make_plane_grid(0.2, 8), kRough);
  press(*step);
  for (int n = 0; n < 20; ++n) step->step(rub_at({0.003 + 2e-5 * n, 0.004, 0.008}));
  const Vec3 force_n = step->step(rub_at({0.0034, 0.004, 0.008})).force_n;
  const Vec3 at = step->proxy().placement().position;
  for (int n = 0; n < 5000; ++n) step->step(rub_at({0.0034, 0.004, 0.008}));
  EXPECT_LT((step->proxy().placement().position - at).norm(), 4.0 * ToolProxy::kContactOffset);
  EXPECT_LT((step->step(rub_at({0.0034, 0.004, 0.008})).force_n - force_n).norm(), 0.02 * force_n.norm());
}

// Of a groove with a right angle each side carries the force over root 2, so that the friction along it is root 2 times that on a plane.
TEST(ToolFriction, AGrooveHoldsByItsSides) {
  TriangleMesh groove;
  groove.vertices = {{-0.1, -0.1, 0.1}, {0.1, -0.1, 0.1}, {-0.1, 0.0, 0.0}, {0.1, 0.0, 0.0}, {-0.1, 0.1, 0.1}, {0.1, 0.1, 0.1}};
  groove.triangles = {{0, 1, 3}, {0, 3, 2}, {2, 3, 5}, {2, 5, 4}};
  TriangleMesh rod = make_cylinder(0.01, 0.04, 64);
  const auto along_x = turn_by({0.0, std::numbers::pi / 2, 0.0});
  for (Vec3& vertex : rod.vertices) vertex = along_x * vertex;
  auto made = ToolStep::make(rod, {std::make_shared<TriangleMesh>(groove)}, {.stiffness_n_per_m = kRubK}, {kRough});
  ASSERT_TRUE(made) << made.error().what;
  ToolStep& step = **made;
  const double rest = 0.01 * std::numbers::sqrt2;
  step.reset(rub_at({0.0, 0.0, rest + 0.005}));
  for (int n = 0; n <= 70; ++n) step.step(rub_at({0.0, 0.0, rest + 0.005 - 1e-4 * n}));
  ToolOutput out;
  for (int n = 0; n < 100; ++n) out = step.step(rub_at({3e-5 * n, 0.0, rest - 0.002}));
  EXPECT_NEAR(out.force_n.z(), kRubK * 0.002, 0.02);
  EXPECT_NEAR(out.force_n.x(), -kRough.friction_dynamic * std::numbers::sqrt2 * out.force_n.z(), 0.02 * out.force_n.z());
}

// Pressed on four corners, turned about the normal: a torque of friction times force times a corner's distance from the axis.
TEST(ToolFriction, ABoxOnItsCornersResistsATurn) {
  const auto step = make_rough_step(make_plane_grid(0.2, 1), kRough);
  step->reset(rub_at({0.0, 0.0, 0.03}));
  for (int n = 0; n <= 220; ++n) step->step(rub_at({0.0, 0.0, 0.03 - 0.0001 * n}));
  const double corner = 0.01 * std::numbers::sqrt2;
  const double limit_nm = kRubK * kDepth * corner;
  double most_nm = 0.0;
  double turn = 0.0;
  // It slides on as long as it is turned, whichever of its contacts carry it.
  for (int n = 0; n < 400; ++n, turn += 1e-3) {
    const ToolOutput out = step->step(rub_at({0.0, 0.0, 0.008}, turn));
    most_nm = std::max(most_nm, -out.torque_nm.z());
    ASSERT_NEAR(out.force_n.z(), kRubK * kDepth, 0.01) << n;
    if (n >= 140) {
      ASSERT_NEAR(-out.torque_nm.z(), kRough.friction_dynamic * limit_nm, 0.15 * kRough.friction_dynamic * limit_nm) << n;
    }
  }
  EXPECT_NEAR(most_nm, kRough.friction_static * limit_nm, 0.02 * limit_nm);
}

TEST(ToolFriction, WithoutFrictionNothingChangesToTheBit) {
  const auto plain = make_rough_step(make_bumpy_sphere(0.05, 0.05, 2000, 1), {});
  auto made = ToolStep::make(make_box({0.02, 0.02, 0.02}), {std::make_shared<TriangleMesh>(make_bumpy_sphere(0.05, 0.05, 2000, 1))},
                             {.stiffness_n_per_m = kRubK});
  ASSERT_TRUE(made);
  for (int n = 0; n < 500; ++n) {
    const ToolInput input = rub_at({1e-5 * n, 0.0, 0.07 - 2e-5 * n});
    ASSERT_EQ(plain->step(input).force_n, (*made)->step(input).force_n);
  }
}

TEST(ToolFriction, TheFastTaskFeelsWhatTheWholeStepFeels) {
  HeldTool held(make_rough_step(make_plane_grid(0.2, 8), kRough));
  const auto whole = make_rough_step(make_plane_grid(0.2, 8), kRough);
  whole->reset(rub_at({0.003, 0.004, 0.03}));
  double most_n = 0.0;
  double moved_n = 0.0;
  for (int n = 0; n < 1500; ++n) {
    const double t = 1e-3 * n;
    const ToolInput input = rub_at({0.003 + 0.01 * std::sin(6.0 * t), 0.004 + 0.008 * std::sin(4.0 * t), std::max(0.03 - 0.1 * t, 0.008)});
    const ToolOutput expected = whole->step(input);
    std::uint64_t heap = 0;
    const AllocationGuard guard;
    const ToolOutput felt = held.step(input, n * 1'000'000);
    heap = AllocationGuard::is_available() ? guard.count() : 0;
    ASSERT_EQ(heap, 0U);
    held.follow();
    if (n < 300) continue;
    most_n = std::max(most_n, expected.force_n.norm());
    moved_n = std::max(moved_n, (felt.force_n - expected.force_n).norm());
  }
  EXPECT_GT(most_n, 2.0);
  EXPECT_LT(moved_n, 0.03 * most_n);
}

TEST(ToolFriction, ImpossibleFrictionIsRejected) {
  for (const CoulombFriction bad : {CoulombFriction{0.1, 0.2}, {-0.1, -0.1}, {std::nan(""), 0.0}, {1.0, std::nan("")}}) {
    const auto made = ToolStep::make(make_box({0.02, 0.02, 0.02}), {std::make_shared<TriangleMesh>(make_plane_grid(0.2, 2))}, {}, {bad});
    EXPECT_FALSE(made);
  }
}

}  // namespace
}  // namespace hapton
