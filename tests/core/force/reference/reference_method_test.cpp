#include "core/force/reference/reference_method.h"

#include <gtest/gtest.h>

#include "tests/core/force/reference/reference_scenes.h"

namespace hapton {
namespace {

TEST(ReferenceMethod, PlaneGivesTheExactDepth) {
  auto method = reference_over(make_plane_grid(0.1, 16));
  method->reset(Vec3(0.0, 0.0, 0.005));
  const std::uint64_t seed = 1;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Vec3 device(0.0, 0.0, 0.001);
  for (int i = 0; i < 2000; ++i) {
    device += 1e-4 * Vec3(normal(random), normal(random), 0.0);
    device.x() = std::clamp(device.x(), -0.045, 0.045);
    device.y() = std::clamp(device.y(), -0.045, 0.045);
    device.z() = 0.0015 * std::sin(0.01 * i);
    const MethodOutput felt = method->step({.p_SD = device});
    const double expected = std::max(0.0, -device.z()) * kReferenceStiffness;
    ASSERT_NEAR(felt.force_n.z(), expected, 1e-6) << i;
    ASSERT_LT(felt.force_n.head<2>().norm(), 1e-6) << i;
    ASSERT_EQ(felt.contact, felt.force_n.norm() > 0.0);
  }
}

TEST(ReferenceMethod, SphereProbeOnThePlaneFeelsItsRadius) {
  const double radius = 0.0005;
  auto method = reference_over(make_plane_grid(0.1, 40), radius);
  method->reset(Vec3(0.0, 0.0, 0.005));
  for (int i = 0; i < 1000; ++i) {
    const Vec3 device(0.03 * std::sin(0.01 * i), 0.03 * std::cos(0.013 * i), 0.001 * std::cos(0.02 * i));
    const MethodOutput felt = method->step({.p_SD = device});
    ASSERT_NEAR(felt.force_n.z(), kReferenceStiffness * std::max(0.0, radius - device.z()), 1e-6) << i;
    ASSERT_LT(felt.force_n.head<2>().norm(), 1e-6);
  }
}

TEST(ReferenceMethod, NothingFallsThroughEdgesAndCorners) {
  const TriangleMesh mesh = make_icosphere(0.05, 3);
  auto method = reference_over(mesh);
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) {
    for (const Vec3& aim : {mesh.corner(i, 0), Vec3(0.5 * (mesh.corner(i, 0) + mesh.corner(i, 1))),
                            Vec3((mesh.corner(i, 0) + mesh.corner(i, 1) + mesh.corner(i, 2)) / 3.0)}) {
      method->reset(1.2 * aim);
      MethodOutput felt;
      for (double part : {1.05, 0.98, 0.97}) felt = method->step({.p_SD = part * aim});
      ASSERT_TRUE(felt.contact);
      ASSERT_NEAR(felt.force_n.norm(), kReferenceStiffness * 0.03 * aim.norm(), 0.1);
      ASSERT_GT(felt.p_SP.norm(), 0.0485);
    }
  }
}

TEST(ReferenceMethod, MotionsInThePlaneOfAFaceStayOutside) {
  // The device moves exactly in the plane of the top face, along its edges and diagonals, then presses in.
  auto method = reference_over(make_box(Vec3::Constant(0.1), 2));
  method->reset(Vec3(-0.07, 0.0, 0.05));
  for (int i = 0; i <= 140; ++i) {
    const MethodOutput felt = method->step({.p_SD = Vec3(-0.07 + 0.001 * i, 0.0, 0.05)});
    ASSERT_GE(felt.p_SP.z(), 0.05);
    ASSERT_LT(felt.force_n.norm(), 1e-6);
  }
  method->reset(Vec3(0.0, 0.0, 0.05));  // exactly on a vertex
  const MethodOutput felt = method->step({.p_SD = Vec3(0.0, 0.0, 0.049)});
  EXPECT_NEAR(felt.force_n.z(), 1.0, 1e-6);
}

TEST(ReferenceMethod, ThinWallHoldsFastMotion) {
  auto method = reference_over(make_thin_wall(0.1, 1e-5, 8));
  method->reset(Vec3(0.001, 0.002, 0.01));
  const MethodOutput felt = method->step({.p_SD = Vec3(0.001, 0.002, -0.01)});
  EXPECT_NEAR(felt.force_n.z(), 10.0 + kReferenceStiffness * 5e-6, 1e-6);
  EXPECT_NEAR(felt.p_SP.z(), 5e-6, 1e-10);
}

// The search begins only when the sphere is near the scene; a large sphere is near while its centre is still far away.
TEST(ReferenceMethod, ASphereLargerThanTheSceneMeetsItFromFarAway) {
  constexpr double kHalf = 0.25;
  for (const double radius : {0.01, 0.4, 0.7, 0.99}) {
    for (const double aside : {-0.1, 0.0, 0.2}) {
      auto method = reference_over(make_box(Vec3::Constant(2.0 * kHalf)), radius);
      method->reset(Vec3(aside, 0.001, 40.0));
      const MethodOutput felt = method->step({.p_SD = {aside, 0.001, kHalf + 0.9 * radius}});
      EXPECT_NEAR(felt.p_SP.z(), kHalf + radius, 1e-6 * radius) << radius;
      EXPECT_NEAR(felt.force_n.z(), 0.1 * kReferenceStiffness * radius, 1e-3) << radius;
    }
  }
}

TEST(ReferenceMethod, OneSidedSurfaceReleasesFromBehind) {
  Material material;
  material.two_sided = false;
  auto method = reference_over(make_plane_grid(0.1, 4), 0.0, material);
  method->reset(Vec3(0.01, 0.02, -0.01));
  EXPECT_FALSE(method->step({.p_SD = Vec3(0.01, 0.02, 0.01)}).contact);
  EXPECT_TRUE(method->step({.p_SD = Vec3(0.011, 0.02, -0.01)}).contact);
}

TEST(ReferenceMethod, NotFiniteInputGivesNoForceAndIsForgotten) {
  auto method = reference_over(make_plane_grid(0.1, 4));
  method->reset(Vec3(0.01, 0.02, 0.01));
  ASSERT_TRUE(method->step({.p_SD = Vec3(0.01, 0.02, -0.001)}).contact);
  for (double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    const MethodOutput felt = method->step({.p_SD = Vec3(0.0, bad, 0.0)});
    EXPECT_FALSE(felt.contact);
    EXPECT_EQ(felt.force_n, Vec3(0, 0, 0));
  }
  EXPECT_NEAR(method->step({.p_SD = Vec3(0.01, 0.02, -0.001)}).force_n.z(), 1.0, 1e-6);
  for (double far : {1e3, 1e30, 1e300}) {
    EXPECT_TRUE(method->step({.p_SD = Vec3(0.01, 0.02, -far)}).force_n.allFinite());
    EXPECT_FALSE(method->step({.p_SD = Vec3(0.01, 0.02, far)}).contact);
  }
  EXPECT_NEAR(method->step({.p_SD = Vec3(0.01, 0.02, -0.001)}).force_n.z(), 1.0, 1e-6);
}

// A straight concave edge along z. From z = 0 on, its walls come closer together and bend aside. A point moves along the edge without
// rising; a sphere, however small, would have to climb at the vertex by a part of its own radius.
TEST(ReferenceMethod, ANarrowingConcaveEdgeDoesNotHoldAPoint) {
  TriangleMesh valley;
  valley.vertices = {{0, 0, -0.05},        {0, 0, 0},        {0, 0, 0.05},       {0.03, 0.02, -0.05}, {0.03, 0.02, 0}, {0.012, 0.02, 0.05},
                     {-0.03, 0.02, -0.05}, {-0.03, 0.02, 0}, {-0.02, 0.02, 0.05}};
  valley.triangles = {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}, {0, 6, 7}, {0, 7, 1}, {1, 7, 8}, {1, 8, 2}};
  for (const double turn : {0.0, 1.0}) {
    TriangleMesh turned = valley;
    const Mat3 rotation = Eigen::AngleAxisd(turn, Vec3(1, 2, 3).normalized()).toRotationMatrix();
    for (Vec3& vertex : turned.vertices) vertex = rotation * vertex;
    auto method = reference_over(turned);
    method->reset(rotation * Vec3(0.0, 0.005, -0.03));
    for (int i = 0; i <= 300; ++i) {
      const Vec3 device(0.0, -0.002, -0.03 + 0.0002 * i);
      const MethodOutput felt = method->step({.p_SD = rotation * device});
      ASSERT_LT((felt.p_SP - rotation * Vec3(0.0, 0.0, device.z())).norm(), 1e-9) << i;
    }
  }
}

TEST(ReferenceMethod, SameForceAtEveryScaleAndPlace) {
  const TriangleMesh mesh = make_bumpy_sphere(0.5, 0.2, 1000, 4);
  std::vector<Vec3> path;
  const std::uint64_t seed = 10;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  random_walk(
      seed, 300,
      [](double u, double v) {
        return Vec3(0.47 * Vec3(std::cos(20 * u) * std::cos(20 * v), std::sin(20 * u) * std::cos(20 * v), std::sin(20 * v)));
      },
      [&](const Vec3& p, int) { path.push_back(p); });
  auto run = [&](double scale, const Vec3& move) {
    auto method = reference_over(scaled_and_moved(mesh, scale, move));
    method->reset(2.0 * path.front() * scale + move);
    std::vector<Vec3> extensions;
    for (const Vec3& p : path) {
      const Vec3 device = p * scale + move;
      extensions.push_back(method->step({.p_SD = device}).force_n / (kReferenceStiffness * scale));
    }
    return extensions;
  };
  const std::vector<Vec3> expected = run(1.0, Vec3::Zero());
  for (const auto& [scale, move, tolerance] : {std::tuple{1e-6, Vec3(0, 0, 0), 1e-8},
                                               {1e6, Vec3(0, 0, 0), 1e-8},
                                               {1.0, Vec3(1e6, -1e6, 1e6), 1e-6},
                                               {0x1p-20, Vec3(0, 0, 0), 0.0}}) {
    const std::vector<Vec3> other = run(scale, move);
    int contacts = 0;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      ASSERT_LE((expected[i] - other[i]).norm(), tolerance) << scale << ' ' << i;
      contacts += expected[i].norm() > 0.0;
    }
    EXPECT_GT(contacts, 100);
  }
}

TEST(ReferenceMethod, PrefilterChangesNothingToTheBit) {
  for (double probe : {0.0, 0.003}) {
    const TriangleMesh mesh = make_bumpy_sphere(0.05, 0.25, 1000, 5);
    auto with_prefilter = reference_over(mesh, probe, {}, true);
    auto without_prefilter = reference_over(mesh, probe, {}, false);
    const std::uint64_t seed = 12;
    SCOPED_TRACE(testing::Message() << "seed " << seed);
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    Vec3 device(0.07, 0.0, 0.0);
    with_prefilter->reset(device);
    without_prefilter->reset(device);
    int contacts = 0;
    for (int i = 0; i < 250; ++i) {
      device +=
          (i % 17 == 0 ? 0.02 : 0.0015) * Vec3(normal(random), normal(random), normal(random)) - 0.05 * device * (device.norm() > 0.07);
      const MethodOutput one = with_prefilter->step({.p_SD = device});
      const MethodOutput two = without_prefilter->step({.p_SD = device});
      ASSERT_EQ(one.force_n, two.force_n) << i;
      ASSERT_EQ(one.p_SP, two.p_SP) << i;
      contacts += one.contact;
    }
    EXPECT_GT(contacts, 50);
    EXPECT_LT(with_prefilter->counters().candidates, without_prefilter->counters().candidates);
  }
}

TEST(ReferenceMethod, FrictionHoldsInsideTheConeAndDragsOnIt) {
  Material material;
  material.friction_static = 0.5;
  material.friction_dynamic = 0.3;
  auto method = reference_over(make_plane_grid(0.1, 10), 0.0, material);
  method->reset(Vec3(0.0, 0.0, 0.001));
  method->step({.p_SD = Vec3(0.0, 0.0, -0.001)});
  bool has_slid = false;
  for (int i = 1; i <= 200; ++i) {
    const double x = 1e-5 * i;
    const Vec3 force = method->step({.p_SD = Vec3(x, 0.0, -0.001)}).force_n;
    const double ratio = -force.x() / force.z();
    ASSERT_LE(ratio, 0.5 + 1e-6);
    if (x < 0.00049) {
      ASSERT_NEAR(force.x(), -kReferenceStiffness * x, 1e-6) << i;
    } else if (x > 0.00052) {
      has_slid = true;
      ASSERT_NEAR(ratio, 0.3, 1e-6) << i;
    }
  }
  EXPECT_TRUE(has_slid);
  // The device goes back until the pull is a tenth of the dynamic cone: the proxy sticks again, until the pull leaves the static cone.
  const double held_x = 0.002 - 0.0003;
  method->step({.p_SD = Vec3(held_x + 0.00003, 0.0, -0.001)});
  EXPECT_NEAR(method->step({.p_SD = Vec3(held_x + 0.00045, 0.0, -0.001)}).force_n.x(), -kReferenceStiffness * 0.00045, 1e-6);
  EXPECT_NEAR(method->step({.p_SD = Vec3(held_x + 0.00055, 0.0, -0.001)}).force_n.x(), -kReferenceStiffness * 0.0003, 1e-6);
}

TEST(ReferenceMethod, DampingResistsGoingInAndNeverPulls) {
  Material material;
  material.damping_ns_per_m = 2.0;
  auto method = reference_over(make_plane_grid(0.1, 4), 0.0, material);
  method->reset(Vec3(0.0, 0.0, 0.001));
  method->step({.p_SD = Vec3(0.0, 0.0, -0.001)});
  EXPECT_NEAR(method->step({.p_SD = Vec3(0.0, 0.0, -0.0011)}).force_n.z(), 1.1 + 0.2, 1e-6);
  EXPECT_NEAR(method->step({.p_SD = Vec3(0.0, 0.0, -0.0010)}).force_n.z(), 1.0 - 0.2, 1e-6);
  const MethodOutput out = method->step({.p_SD = Vec3(0.0, 0.0, -0.00001)});
  EXPECT_EQ(out.force_n.z(), 0.0);
  EXPECT_TRUE(out.contact) << "the surface holds it all the same";
  EXPECT_EQ(out.object, 0);
  EXPECT_NEAR(out.p_SP.z(), 0.0, 1e-9);
}

TEST(ReferenceMethod, RejectsImpossibleSettings) {
  MethodSettings settings;
  settings.reference_substeps = 0;
  EXPECT_FALSE(ReferenceMethod::make(settings, scene_of(make_plane_grid(0.1, 1))).has_value());
  settings.reference_substeps = 8;
  settings.reference_substep_limit = 4;
  EXPECT_FALSE(ReferenceMethod::make(settings, scene_of(make_plane_grid(0.1, 1))).has_value());
  settings.reference_substep_limit = 8;
  settings.probe_radius_m = -1.0;
  EXPECT_FALSE(ReferenceMethod::make(settings, scene_of(make_plane_grid(0.1, 1))).has_value());
  settings.probe_radius_m = 0.0;
  EXPECT_FALSE(ReferenceMethod::make(settings, scene_of(TriangleMesh{})).has_value());
}

}  // namespace
}  // namespace hapton
