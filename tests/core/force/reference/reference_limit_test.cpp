#include <gtest/gtest.h>

#include "tests/core/force/reference/reference_scenes.h"

namespace hapton {
namespace {

TEST(ReferenceMethod, ReleasedAtAConvexEdgeInMidStepItConvergesToTheEvent) {
  const double gap = kGap;
  MethodOutput felt;
  const auto method = limit_over(block_and_shelf(gap), 8, 64);
  const ReferenceStep step = jump(*method, 0.53, felt);
  EXPECT_TRUE(step.settled);
  EXPECT_EQ(step.substeps, 32);
  EXPECT_FALSE(felt.contact);
  EXPECT_EQ(felt.p_SP, Vec3(0.47 * kJump, -kDepth, 0.0));
  EXPECT_EQ(method->counters().unsettled_steps, 0u);
}

TEST(ReferenceMethod, AForceThatStillChangesAtTheLimitOfSubStepsHasNotSettled) {
  MethodOutput felt;
  const auto method = limit_over(block_and_shelf(kGap), 8, 16);
  const ReferenceStep step = jump(*method, 0.53, felt);
  EXPECT_FALSE(step.settled);
  EXPECT_EQ(step.substeps, 16);
  EXPECT_GT(step.change, 0.1);
  EXPECT_EQ(method->counters().unsettled_steps, 1u);
  EXPECT_NE(method->describe().find("1 not settled"), std::string::npos) << method->describe();
}

// The shelf is divided by plates, each half as far from the block as the next: with each halving of the sub-step the proxy falls between
// other plates.
TEST(ReferenceMethod, AChaoticStepIsReportedNotSettled) {
  TriangleMesh mesh = block_and_shelf(1e-6);
  for (double x = 0.71 * kJump; x > 1e-5; x *= 0.5) {
    mesh = joined(mesh, box_between({x, -0.018, -0.05}, {1.05 * x, -0.012, 0.05}));
  }
  MethodOutput felt;
  const auto method = limit_over(mesh, 2, 512);
  const ReferenceStep step = jump(*method, 0.5 + 1e-5, felt);
  EXPECT_FALSE(step.settled);
  EXPECT_EQ(step.substeps, 512);
  EXPECT_GT(step.change, 1e-6);
  EXPECT_TRUE(felt.contact);
}

// A gutter of two walls at 45 degrees. The device moves along x below it. In mid-step the multiplier of the left wall reaches zero: from
// then on the proxy is the projection of the device onto the right wall.
TEST(ReferenceMethod, ReleasedFromAConcaveEdgeInMidStepItIsOnTheOtherWall) {
  for (const int substeps : {1, 3, 8, 32}) {
    const auto method = limit_over(make_gutter(0.1, 0.02, std::numbers::pi / 2.0, 2), substeps, 1024);
    const double apex = compute_bounds(make_gutter(0.1, 0.02, std::numbers::pi / 2.0, 2)).high.y() - 0.02;
    const double depth = 0.01;
    method->reset(Vec3(0.0, apex + 0.001, 0.0));
    method->step({.p_SD = Vec3(0.002, apex - depth, 0.0)});
    const MethodOutput felt = method->step({.p_SD = Vec3(0.016, apex - depth, 0.0)});  // released at x = depth
    // The right wall rises as (1, 1) / sqrt 2: its height over the apex is the mean of x and y.
    const double along = 0.5 * (0.016 - depth);
    EXPECT_LT((felt.force_n / kReferenceStiffness - Vec3(along - 0.016, along + depth, 0.0)).norm(), 1e-12) << substeps;
    EXPECT_TRUE(method->last_step().settled);
    EXPECT_EQ(method->last_step().substeps, 2 * substeps);
  }
}

// Inside a prism of eight sides the proxy stays on its face until the device's projection passes an edge, however near another face is.
TEST(ReferenceMethod, OverTheEdgesOfAPrismItIsTheProjection) {
  constexpr double kEighth = std::numbers::pi / 4.0;
  const double radius = 0.05;
  const double half_side = radius * std::sin(0.5 * kEighth);
  const auto method = limit_over(make_cylinder(radius, 0.1, 8), 1, 1024);
  const auto device_at = [](double angle) { return Vec3(0.044 * std::cos(angle), 0.044 * std::sin(angle), 0.0); };
  double face = 0.5 * kEighth;
  method->reset(Vec3(0.06 * std::cos(face), 0.06 * std::sin(face), 0.0));
  method->step({.p_SD = device_at(face)});
  for (int i = 1; i < 60; ++i) {
    const Vec3 device = device_at(0.5 * kEighth + 0.37 * i);
    while (device.dot(Vec3(-std::sin(face), std::cos(face), 0.0)) > half_side) face += kEighth;
    const Vec3 normal(std::cos(face), std::sin(face), 0.0);
    const Vec3 expected = device + (radius * std::cos(0.5 * kEighth) - device.dot(normal)) * normal;
    EXPECT_LT((method->step({.p_SD = device}).force_n / kReferenceStiffness + device - expected).norm(), 1e-12) << i;
    EXPECT_TRUE(method->last_step().settled) << i;
  }
}

// Dragged over a plane by a device that changes its direction, the proxy follows tractrices; the length of the sub-steps does not matter.
TEST(ReferenceMethod, FrictionOnAPlaneIsTheTractrix) {
  Material material;
  material.friction_static = 0.4;
  material.friction_dynamic = 0.4;
  const auto coarse = limit_over(make_plane_grid(0.1, 3), 1, 1024, material);
  const auto fine = limit_over(make_plane_grid(0.1, 3), 64, 1024, material);
  const double depth = 0.001;
  const double cone = 0.4 * depth;
  for (ReferenceMethod* method : {coarse.get(), fine.get()}) {
    method->reset(Vec3(-0.01, 0.001, 0.001));
    method->step({.p_SD = Vec3(-0.01, 0.001, -depth)});
    method->step({.p_SD = Vec3(0.0, 0.001, -depth)});  // slides: the pull is the cone, along x
    const MethodOutput felt = method->step({.p_SD = Vec3(0.0, 0.001 + 2.0 * cone, -depth)});
    const Vec3 pull(cone / std::cosh(2.0), cone * std::tanh(2.0), -depth);  // from the proxy to the device
    EXPECT_LT((felt.force_n / kReferenceStiffness + pull).norm(), 1e-12);
    EXPECT_TRUE(method->last_step().settled);
  }
}

TEST(ReferenceMethod, TheForceOnAPointIsWithoutTheRadiusOfItsSphere) {
  const auto method = reference_over(make_plane_grid(0.1, 4));
  method->reset(Vec3(0.001, 0.002, 0.001));
  const MethodOutput felt = method->step({.p_SD = Vec3(0.001, 0.002, -0.001)});
  EXPECT_NEAR(felt.force_n.z(), kReferenceStiffness * 0.001, 1e-13);
  EXPECT_GT(felt.p_SP.z(), 0.0);
  EXPECT_FALSE(method->step({.p_SD = Vec3(0.001, 0.002, 1e-11)}).contact);
}

TEST(ReferenceMethod, ResumeGoesOnFromAnotherMethodsProxy) {
  Material material;
  material.friction_static = 0.5;
  material.friction_dynamic = 0.3;
  const auto first = limit_over(make_plane_grid(0.1, 4), 8, 64, material);
  const auto second = limit_over(make_plane_grid(0.1, 4), 8, 64, material);
  first->reset(Vec3(0.0, 0.0, 0.001));
  first->step({.p_SD = Vec3(0.0, 0.0, -0.001)});
  const Vec3 device(0.003, 0.001, -0.001);
  const MethodOutput sliding = first->step({.p_SD = device});
  second->continue_from(sliding.p_SP, device, true);
  for (int i = 1; i < 20; ++i) {
    const Vec3 next = device + Vec3(2e-5 * i, 5e-5 * i, 1e-6 * i);
    EXPECT_LT((first->step({.p_SD = next}).force_n - second->step({.p_SD = next}).force_n).norm(), 1e-9) << i;
  }
  second->continue_from(Vec3(0.0, 0.0, 0.01), Vec3(0.0, 0.0, 0.01), false);
  EXPECT_FALSE(second->step({.p_SD = Vec3(0.0, 0.0, 0.005)}).contact);
}

// The device slides under friction over bumps with radii smaller than the depth; every step is compared with method proxy, an independent
// implementation. Before the reference used the steepest direction at a vertex, stood on both faces of a concave edge and halved the
// sub-steps in which friction lets it slip, it differed by up to 158 % of the force, and by more than 1e-6 in one of 90 steps.
TEST(ReferenceMethod, UnderFrictionItIsWhereTheProxyIs) {
  Material material;
  material.friction_static = 0.5;
  material.friction_dynamic = 0.4;
  const TriangleMesh mesh = make_rough_sphere(0.049, 0.0007, 0.0025, 80000, 1);
  const auto reference = limit_over(mesh, 64, 1024, material);
  const auto proxy = make_method({}, scene_of(mesh, material));
  ASSERT_TRUE(proxy.has_value());
  for (const std::uint64_t seed : {1, 2, 3}) {
    const auto slide = make_slide_trajectory(mesh, {.seed = seed, .rows = 650});
    ASSERT_TRUE(slide.has_value());
    int contacts = 0;
    int inexact_steps = 0;
    for (std::size_t i = 0; i < slide->p_SD.size(); ++i) {
      const Vec3& device = slide->p_SD[i];
      if (i == 0) {
        reference->reset(device);
        (*proxy)->reset(device);
      }
      const Vec3 expected = reference->step({.p_SD = device}).force_n;
      const Vec3 felt = (*proxy)->step({.p_SD = device}).force_n;
      const double relative_error = (felt - expected).norm() / std::max(expected.norm(), 1e-3);
      ASSERT_LT(relative_error, 1e-3) << "seed " << seed << ", row " << i;
      contacts += expected.norm() > 0.0;
      inexact_steps += relative_error > 1e-5;
    }
    EXPECT_GT(contacts, 400);
    EXPECT_LT(inexact_steps, contacts / 50) << "seed " << seed;
  }
}

TEST(ReferenceMethod, SettleFromMovesAProxyThatWasNotAtAMinimum) {
  auto method = reference_over(make_plane_grid(0.1, 4));
  const MethodOutput rested = method->settle_from(Vec3(0.001, 0.002, 0.0), Vec3(0.001, 0.002, -0.001));
  EXPECT_LT((rested.p_SP - Vec3(0.001, 0.002, 0.0)).norm(), 1e-9);
  const MethodOutput moved = method->settle_from(Vec3(0.011, 0.002, 1e-10), Vec3(0.001, 0.002, -0.001));
  EXPECT_LT((moved.p_SP - Vec3(0.001, 0.002, 0.0)).norm(), 1e-9);
}

// The gap between two sheets narrows towards the device; at the start the sphere of the point just fits. The start is given up to half the
// radius nearer to the lower sheet, as rounding does far from the origin. With that overlap it would fit up to the device.
TEST(ReferenceMethod, SettleFromAPositionThatIsRoundedStaysWhereItsSphereFillsASlit) {
  constexpr double kRadius = ReferenceProxy::kPointRadius;
  TriangleMesh sheets;
  for (const double narrowing : {0.0, 2.0 * kRadius}) {
    const auto first = static_cast<std::uint32_t>(sheets.vertices.size());
    const double height = narrowing > 0.0 ? 2.0 * kRadius : 0.0;
    for (const double x : {-0.3, 0.3}) {
      for (const double y : {-0.3, 0.3}) sheets.vertices.emplace_back(x, y, height - narrowing * x);
    }
    sheets.triangles.push_back({first, first + 1, first + 3});
    sheets.triangles.push_back({first, first + 3, first + 2});
  }
  auto method = reference_over(sheets);
  for (const double z : {kRadius, 0.75 * kRadius, 0.5 * kRadius}) {
    EXPECT_LT(method->settle_from(Vec3(0.0, 0.0, z), Vec3(0.1, 0.0, -0.02)).p_SP.x(), 1e-3) << z / kRadius;
  }
}

// The proxy is in the groove between two spikes of a star, just below its end; the device is beyond the end and a little lower: the groove
// holds it. The edges between the triangles of a wall lean along the groove by more than the device pulls.
TEST(ReferenceMethod, EdgesWithinAWallDoNotHoldWhatSlidesAlongIt) {
  const double extent = compute_bounds(make_stress_body("star").touched).extent();
  const double inner = 0.12 * 0.1;
  const double angle = 0.6 * std::numbers::pi;
  for (const double offset : {0.0, 10.0, 1000.0}) {  // far from the origin, the triangles of a wall lie in one plane only to rounding
    const Vec3 middle = offset * extent * Vec3(1.0, -1.0, 1.0);
    const StressBody star = placed(make_stress_body("star"), 1.0, middle);
    const double top = compute_bounds(star.touched).high.z();
    auto method = reference_over(star.touched);
    for (const double below : {0.0, 1e-15, 1e-14, 1e-13, 1e-12, 1e-11}) {
      const Vec3 groove = middle + Vec3(inner * std::cos(angle), inner * std::sin(angle), 0.0);
      const Vec3 start(groove.x() - 5e-11, groove.y() + 1.54e-10, top - below);
      const Vec3 device(middle.x() + 0.0591, middle.y() - 0.0735, top - 1e-7);
      const Vec3 end = method->settle_from(start, device).p_SP;
      EXPECT_LT((end - Vec3(groove.x(), groove.y(), device.z())).norm(), 1e-9) << "offset " << offset << " below " << below;
    }
  }
}

}  // namespace
}  // namespace hapton
