#include <gtest/gtest.h>

#include "tests/core/force/reference/reference_scenes.h"

namespace hapton {
namespace {

// Inside a box the free space is convex, so the proxy is the projection onto it: exact on faces, edges and corners, in one step.
TEST(ReferenceMethod, RoomCornersAreExactProjections) {
  for (double probe : {0.0, 0.002}) {
    auto method = reference_over(make_box(Vec3::Constant(0.1), 5), probe);
    method->reset(Vec3::Zero());
    const std::uint64_t seed = 2;
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> symmetric(-1.0, 1.0);
    Vec3 last_force = Vec3::Zero(), last_device = Vec3::Zero();
    for (int i = 0; i < 1500; ++i) {
      const Vec3 device = 0.06 * Vec3(symmetric(random), symmetric(random), symmetric(random));
      const Vec3 expected = device.cwiseMax(-0.05 + probe).cwiseMin(0.05 - probe);
      const MethodOutput felt = method->step({.p_SD = device});
      ASSERT_LT((felt.p_SP - expected).norm(), 1e-9) << i << " probe " << probe;
      ASSERT_LT((felt.force_n - kReferenceStiffness * (expected - device)).norm(), 1e-6);
      ASSERT_LE((felt.force_n - last_force).norm(), kReferenceStiffness * (device - last_device).norm() + 1e-6);  // firmly non-expansive
      last_force = felt.force_n;
      last_device = device;
    }
    EXPECT_EQ(method->counters().proxy.unconverged, 0u);
    EXPECT_EQ(method->counters().unsettled_steps, 0u);
  }
}

TEST(ReferenceMethod, BoxFacesFromOutside) {
  auto method = reference_over(make_box(Vec3::Constant(0.1), 4));
  for (int axis = 0; axis < 3; ++axis) {
    for (double side : {-1.0, 1.0}) {
      Vec3 start = Vec3::Zero();
      start[axis] = side * 0.06;
      method->reset(start);
      for (int i = 0; i < 300; ++i) {
        Vec3 device(0.02 * std::sin(0.05 * i), 0.03 * std::cos(0.07 * i), 0.02 * std::sin(0.03 * i + 1.0));
        device[axis] = side * (0.06 - 0.012 * std::min(1.0, i / 100.0));
        const MethodOutput felt = method->step({.p_SD = device});
        Vec3 expected = Vec3::Zero();
        expected[axis] = side * kReferenceStiffness * std::max(0.0, 0.05 - std::abs(device[axis]));
        ASSERT_LT((felt.force_n - expected).norm(), 1e-6) << axis << ' ' << i;
      }
    }
  }
}

TEST(ReferenceMethod, SphereWithinTheSagitta) { expect_close_to_analytic(make_sphere_case(), 0.0); }

TEST(ReferenceMethod, CylinderWithinTheSagitta) { expect_close_to_analytic(make_cylinder_case(), 0.0); }

TEST(ReferenceMethod, TorusWithinTheSagitta) { expect_close_to_analytic(make_torus_case(), 0.0); }

TEST(ReferenceMethod, SphereProbeOnASphere) { expect_close_to_analytic(make_sphere_case(), 0.0005); }

TEST(ReferenceMethod, SphereProbeOnATorus) { expect_close_to_analytic(make_torus_case(), 0.002); }

// A sphere rolls about the boundary edge of a sheet, where its equilibrium is known in closed form.
TEST(ReferenceMethod, SphereProbeRollsAboutAnOpenEdge) {
  // A half plane z = 0, x <= 0: its boundary is the y axis. A sphere of radius r settles on it where the device pulls it.
  TriangleMesh sheet;
  sheet.vertices = {{-0.1, -0.1, 0}, {0, -0.1, 0}, {0, 0.1, 0}, {-0.1, 0.1, 0}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  const double radius = 0.01;
  auto method = reference_over(sheet, radius);
  method->reset(Vec3(0.001, 0.0, 0.02));
  for (int i = 0; i <= 100; ++i) {
    const Vec3 device(0.001 + 2e-5 * i, 1e-4 * i, 0.02 - 1.5e-4 * i);
    const MethodOutput felt = method->step({.p_SD = device});
    const Vec3 out(device.x(), 0.0, device.z());
    Vec3 expected = device;
    if (out.norm() < radius) expected = radius * out.normalized() + Vec3(0, device.y(), 0);
    ASSERT_LT((felt.p_SP - expected).norm(), 1e-9) << i;
  }
  // One motion along the edge, one round it, and a third that finds nothing left to do: the motion round the edge does not lead along it.
  EXPECT_NE(method->describe().find("at most 3 motions in one sub-step"), std::string::npos) << method->describe();
}

// While the device holds still, a sphere slips off the edge of a box under friction: first round the edge along its pull, which turns on
// the way, then straight down the side until the pull is on the dynamic cone.
TEST(ReferenceMethod, SphereUnderFrictionSlipsRoundAnEdgeAlongItsPull) {
  constexpr double kHalf = 0.02, kRadius = 0.002, kDynamic = 0.2;
  auto method = reference_over(make_box(Vec3::Constant(2.0 * kHalf)), kRadius, {.friction_static = 0.3, .friction_dynamic = kDynamic});
  const Vec3 edge(kHalf, 0.0, kHalf);  // along y
  for (const double y : {0.003, 0.006, -0.009}) {
    const Vec3 device(0.017, y, 0.005);
    const double start_angle = 20.0 * std::numbers::pi / 180.0;
    Vec3 expected = edge + kRadius * Vec3(std::sin(start_angle), 0.0, std::cos(start_angle));
    const Vec3 start = expected;
    const auto pull_at = [&](const Vec3& centre) -> Vec3 {
      const Vec3 normal = Vec3(centre.x() - kHalf, 0.0, centre.z() - kHalf).normalized();
      const Vec3 pull = device - centre;
      return pull - pull.dot(normal) * normal;
    };
    constexpr double kPiece = 2e-8;  // m: with the midpoint rule, an error of 1e-15 m
    while (expected.z() > kHalf) {
      const Vec3 middle = expected + 0.5 * kPiece * pull_at(expected).normalized();
      expected += kPiece * pull_at(middle).normalized();
      const Vec3 out(expected.x() - kHalf, 0.0, expected.z() - kHalf);
      expected += (kRadius / out.norm() - 1.0) * out;
    }
    expected.x() = kHalf + kRadius;
    const Vec3 over(0.0, device.y() - expected.y(), device.z() - expected.z());
    expected += over - kDynamic * (expected.x() - device.x()) * over.normalized();
    method->reset(Vec3(0.0, 0.0, 0.1));
    method->continue_from(start, device, true);
    const MethodOutput felt = method->step({.p_SD = device});
    EXPECT_LT((felt.p_SP - expected).norm(), 2e-8) << y;
  }
}

}  // namespace
}  // namespace hapton
