#include "core/force/proxy/proxy_method.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "core/force/reference/reference_method.h"
#include "core/geometry/mesh_shapes.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/made_scene.h"

namespace hapton {
namespace {

std::unique_ptr<ProxyMethod> proxy_over(const TouchScene& scene, double radius_m = 0.0) {
  MethodSettings settings;
  settings.probe_radius_m = radius_m;
  auto made = ProxyMethod::make(settings, scene);
  return std::unique_ptr<ProxyMethod>(static_cast<ProxyMethod*>(made.value().release()));
}

MethodOutput press(ForceMethod& method, const Vec3& from, const Vec3& to, int steps = 1) {
  method.reset(from);
  MethodOutput felt;
  for (int i = 1; i <= steps; ++i) felt = method.step({.p_SD = from + (to - from) * (static_cast<double>(i) / steps)});
  return felt;
}

TEST(Proxy, APlaneFollowsHookesLawFromEitherSide) {
  const auto proxy = proxy_over(scene_of(make_plane_grid(0.1, 8)));
  for (const double side : {1.0, -1.0}) {
    const MethodOutput felt = press(*proxy, {0.011, 0.007, side * 0.01}, {0.013, 0.008, -side * 0.002}, 5);
    EXPECT_TRUE(felt.contact);
    EXPECT_NEAR((felt.force_n - Vec3(0, 0, side * 2.0)).norm(), 0.0, 1e-9);
    EXPECT_NEAR((felt.p_SP - Vec3(0.013, 0.008, 0)).norm(), 0.0, 1e-9);
  }
}

TEST(Proxy, ASphereProbeStaysOffByItsRadius) {
  const auto proxy = proxy_over(scene_of(make_plane_grid(0.1, 8)), 0.003);
  const MethodOutput felt = press(*proxy, {0.011, 0.007, 0.01}, {0.013, 0.008, 0.001}, 5);
  EXPECT_NEAR((felt.force_n - Vec3(0, 0, 2.0)).norm(), 0.0, 1e-8);
  EXPECT_FALSE(press(*proxy, {0.011, 0.007, 0.01}, {0.013, 0.008, 0.0031}, 5).contact);
}

TEST(Proxy, ACornerOfThreePlanesNeedsOneStep) {
  const auto proxy = proxy_over(scene_of(make_pit(0.1, 0.02)));
  const auto reference = ReferenceMethod::make(MethodSettings(), scene_of(make_pit(0.1, 0.02)));
  const Vec3 from(0.001, 0.002, 0.06);
  const Vec3 to(0.002, 0.001, 0.027);
  const MethodOutput felt = press(*proxy, from, to, 1);
  const MethodOutput again = proxy->step({.p_SD = to});
  ASSERT_GT(felt.force_n.norm(), 1.0);
  EXPECT_LE((felt.force_n - again.force_n).norm(), 1e-9 * felt.force_n.norm()) << "one step was not enough";
  const MethodOutput expected = press(**reference, from, to, 1);
  EXPECT_LE((felt.force_n - expected.force_n).norm(), 1e-5 * expected.force_n.norm());
}

TEST(Proxy, NoEdgeOrVertexLetsItThrough) {
  const TriangleMesh mesh = make_icosphere(0.05, 3);
  const auto proxy = proxy_over(scene_of(mesh));
  const auto tap = [&](const Vec3& at) {
    const Vec3 outward = at.normalized();
    const MethodOutput felt = press(*proxy, at + 0.005 * outward, at - 0.001 * outward, 3);
    EXPECT_TRUE(felt.contact);
    double highest = -1.0;  // above the plane of one face at least: outside the convex body
    for (const Triangle& t : mesh.triangles) {
      const Vec3 normal = (mesh.vertices[t[1]] - mesh.vertices[t[0]]).cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]).normalized();
      highest = std::max(highest, normal.dot(felt.p_SP - mesh.vertices[t[0]]));
    }
    EXPECT_GT(highest, 0.0);
  };
  for (const Vec3& vertex : mesh.vertices) tap(vertex);
  for (const Triangle& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) tap(0.5 * (mesh.vertices[t[k]] + mesh.vertices[t[(k + 1) % 3]]));
  }
}

TEST(Proxy, OverAPlaneTheProxyMovesNoFartherThanTheDevice) {
  constexpr unsigned kSeed = 404;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  for (const double radius : {0.0, 0.004}) {
    const auto proxy = proxy_over(scene_of(make_plane_grid(0.1, 12)), radius);
    std::mt19937_64 random(kSeed);
    std::normal_distribution<double> normal;
    Vec3 device(0, 0, 0.005);
    proxy->reset(device);
    MethodOutput last = proxy->step({.p_SD = device});
    for (int i = 0; i < 20000; ++i) {
      Vec3 next = device + 2e-4 * Vec3(normal(random), normal(random), normal(random));
      next = next.cwiseMax(Vec3(-0.04, -0.04, -0.003)).cwiseMin(Vec3(0.04, 0.04, 0.01));
      const MethodOutput felt = proxy->step({.p_SD = next});
      EXPECT_LE((felt.p_SP - last.p_SP).norm(), (next - device).norm() + 1e-9);
      EXPECT_LE((felt.force_n - last.force_n).norm(), 1000.0 * (next - device).norm() + 1e-6);
      device = next;
      last = felt;
    }
  }
}

// A path once around a ball. It begins above the surface; from step 20 on it is at the depth.
std::vector<Vec3> path_around_ball(double radius_m, double depth_m, int steps) {
  std::vector<Vec3> path;
  for (int i = 0; i < steps; ++i) {
    const double a = 2.0 * std::numbers::pi * i / steps;
    const Vec3 out(std::cos(a), std::sin(a), 0.3 * std::sin(3.0 * a));
    path.push_back(out.normalized() * (radius_m + (i < 20 ? 0.001 * (20 - i) : -depth_m)));
  }
  return path;
}

TEST(Proxy, ScaleDoesNotMatter) {
  const TriangleMesh mesh = make_bumpy_sphere(0.05, 0.08, 5000, 9);
  const std::vector<Vec3> path = path_around_ball(0.05, 0.002, 2000);
  std::vector<Vec3> expected;
  for (const double scale : {1.0, 0x1p-20, 0x1p20}) {
    const auto proxy = proxy_over(scene_of(scaled_and_moved(mesh, scale, Vec3::Zero())));
    proxy->reset(scale * path[0]);
    for (std::size_t i = 0; i < path.size(); ++i) {
      const Vec3 extension = proxy->step({.p_SD = scale * path[i]}).force_n / (1000.0 * scale);
      if (scale == 1.0) {
        expected.push_back(extension);
      } else {
        EXPECT_EQ(extension, expected[i]) << "scale " << scale << " step " << i;  // scaling by powers of two: equal to the bit
      }
    }
  }
}

TEST(Proxy, TurningAndMovingTheWorldTurnsTheForce) {
  const TriangleMesh mesh = make_icosphere(0.05, 4);
  const std::vector<Vec3> path = path_around_ball(0.05, 0.002, 1000);
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  pose.translation() = Vec3(3, -2, 1);
  TriangleMesh moved = mesh;
  for (Vec3& v : moved.vertices) v = pose * v;
  const auto original = proxy_over(scene_of(mesh));
  const auto turned_proxy = proxy_over(scene_of(moved));
  original->reset(path[0]);
  turned_proxy->reset(pose * path[0]);
  for (const Vec3& p : path) {
    const Vec3 f = original->step({.p_SD = p}).force_n;
    const Vec3 g = turned_proxy->step({.p_SD = pose * p}).force_n;
    EXPECT_LE((pose.linear() * f - g).norm(), 1e-6);
  }
}

TEST(Proxy, FarFromTheOriginItFeelsTheSame) {
  const TriangleMesh mesh = make_icosphere(0.05, 4);
  const Vec3 far(1e6, -1e6, 5e5);
  const auto at_origin = proxy_over(scene_of(mesh));
  const auto far_away = proxy_over(scene_of(scaled_and_moved(mesh, 1.0, far)));
  const std::vector<Vec3> path = path_around_ball(0.05, 0.002, 1000);
  at_origin->reset(path[0]);
  far_away->reset(far + path[0]);
  for (const Vec3& p : path) {
    const MethodOutput a = at_origin->step({.p_SD = p});
    const MethodOutput b = far_away->step({.p_SD = far + p});
    EXPECT_EQ(a.contact, b.contact);
    EXPECT_LE((a.force_n - b.force_n).norm(), 1e-3) << "positions there are known to 1e-10 m, facets tilt that little";
  }
}

TEST(Proxy, FrictionlessWorkRoundAClosedPathIsZero) {
  // On a plane and at a concave edge, where no convex edge lets the proxy jump. Along straight pieces of the path the force is linear.
  Pose top_to_z = Pose::Identity();  // the gutter's top faces +y; its concave edge is at 0.03
  top_to_z.linear() = Eigen::AngleAxisd(0.5 * std::numbers::pi, Vec3::UnitX()).toRotationMatrix();
  top_to_z.translation() = Vec3(0, 0, -0.05);
  TriangleMesh gutter = make_gutter(0.1, 0.02, 1.5, 20);
  for (Vec3& v : gutter.vertices) v = top_to_z * v;
  for (const TriangleMesh& mesh : {make_plane_grid(0.1, 16), gutter}) {
    const auto proxy = proxy_over(scene_of(mesh));
    const int round_steps = 3000;
    double work = 0.0;
    double absolute_work = 0.0;
    Vec3 last_p = Vec3::Zero();
    MethodOutput last_felt;
    proxy->reset({0, 0, 0.03});
    for (int i = 0; i <= 2 * round_steps; ++i) {
      const double a = 2.0 * std::numbers::pi * i / round_steps;
      const Vec3 p(0.01 * std::cos(a), 0.0004 * std::sin(a), -0.0225 + 0.0015 * std::sin(2.0 * a));
      const MethodOutput felt = proxy->step({.p_SD = p});
      if (i > round_steps) {
        const double piece = 0.5 * (felt.force_n + last_felt.force_n).dot(p - last_p);
        work += piece;
        absolute_work += std::fabs(piece);
      }
      last_p = p;
      last_felt = felt;
    }
    EXPECT_GT(absolute_work, 1e-3);
    EXPECT_LE(std::fabs(work), 1e-6 * absolute_work);
  }
}

TEST(Proxy, FrictionStaysInsideItsCone) {
  Material rough;
  rough.friction_static = 0.5;
  rough.friction_dynamic = 0.3;
  const auto proxy = proxy_over(scene_of(make_plane_grid(0.2, 10), rough));
  proxy->reset({0, 0, 0.001});
  Vec3 device(0, 0, -0.002);
  proxy->step({.p_SD = device});
  double most_stuck_n = 0.0;
  bool has_slid = false;
  for (int i = 0; i < 400; ++i) {
    device.x() += 2e-5;
    const MethodOutput felt = proxy->step({.p_SD = device});
    const double normal = felt.force_n.z();
    const double tangential = felt.force_n.head<2>().norm();
    EXPECT_NEAR(normal, 2.0, 1e-6);
    EXPECT_LE(tangential, rough.friction_static * normal * (1.0 + 1e-6));
    EXPECT_LE(felt.force_n.x(), 1e-9) << "friction pushes along the motion";
    if (!has_slid) most_stuck_n = std::max(most_stuck_n, tangential);
    if (tangential < most_stuck_n - 0.1) has_slid = true;
    if (has_slid) {
      EXPECT_NEAR(tangential, rough.friction_dynamic * normal, 1e-3);
    }
  }
  EXPECT_TRUE(has_slid);
  EXPECT_NEAR(most_stuck_n, rough.friction_static * 2.0, 0.03);
}

TEST(Proxy, DampingIsUsedAndNeverPullsIn) {
  Material damped;
  damped.damping_ns_per_m = 5.0;
  const auto proxy = proxy_over(scene_of(make_plane_grid(0.1, 4), damped));
  proxy->reset({0, 0, 0.001});
  proxy->step({.p_SD = Vec3(0, 0, -0.001)});
  const MethodOutput in = proxy->step({.p_SD = Vec3(0, 0, -0.0012)});  // 0.2 m/s inward
  EXPECT_NEAR(in.force_n.z(), 1.2 + 1.0, 1e-6);
  const MethodOutput out = proxy->step({.p_SD = Vec3(0, 0, -0.0002)});  // 1 m/s outward: damping alone would be attractive
  EXPECT_GE(out.force_n.z(), 0.0);
  EXPECT_LE(out.force_n.z(), 1e-9);
  EXPECT_TRUE(out.contact) << "the surface holds it all the same";
  EXPECT_EQ(out.object, 0);
  EXPECT_NEAR(out.p_SP.z(), 0.0, 1e-9);
}

// A sample may be found to be in free space without a query of the surface. A correction of that sample is damped with the device's motion
// since the sample before it, not with the correction alone.
TEST(Proxy, ACorrectionIsDampedAsItsSample) {
  Material damped;
  damped.damping_ns_per_m = 2.0;
  const auto proxy = proxy_over(scene_of(make_plane_grid(0.1, 4), damped));
  const auto at = [](double z) { return Vec3(0.0013, 0.0021, z); };
  for (const std::vector<double>& heights : {std::vector{0.006, 0.0055, 0.0018, 0.0016}, std::vector{0.006, 0.0055}}) {
    const std::size_t count = heights.size();
    const std::uint64_t skipped_before = proxy->counters().skipped;
    proxy->reset(at(heights[0]));
    for (std::size_t i = 1; i < count; ++i) EXPECT_FALSE(proxy->step({.p_SD = at(heights[i])}).contact) << i;
    EXPECT_FALSE(proxy->step({.p_SD = at(0.0017), .is_correction = true}).contact);
    EXPECT_EQ(proxy->counters().skipped - skipped_before, count - 1) << "all but the first are in the empty ball";
    // The device moves from the sample before to a depth of 0.5 mm in a millisecond.
    const double moved_mm = 1e3 * heights[count - 2] + 0.5;
    EXPECT_NEAR(proxy->step({.p_SD = at(-0.0005), .is_correction = true}).force_n.z(), 0.5 + 2.0 * moved_mm, 1e-3) << count;
  }
}

TEST(Proxy, OneSidedSurfacesLetTheDeviceThroughFromBehind) {
  Material front_only;
  front_only.two_sided = false;
  const auto proxy = proxy_over(scene_of(make_plane_grid(0.1, 4), front_only));
  EXPECT_TRUE(press(*proxy, {0.011, 0.007, 0.01}, {0.011, 0.007, -0.002}, 3).contact);
  EXPECT_FALSE(press(*proxy, {0.011, 0.007, -0.01}, {0.011, 0.007, 0.002}, 3).contact);
}

TEST(Proxy, AConcaveEdgeReleasesTheProxyAgain) {
  // Press into a gutter, slide along it and lift out: the force never exceeds what the device's depth explains.
  for (const double opening : {0.2, 1.0, 2.0}) {
    const auto proxy = proxy_over(scene_of(make_gutter(0.1, 0.02, opening, 40)));
    proxy->reset({0, 0.06, -0.03});
    MethodOutput felt;
    for (int i = 0; i <= 200; ++i) felt = proxy->step({.p_SD = Vec3(0, 0.06 - 0.0002 * i, -0.03)});
    ASSERT_GT(felt.force_n.y(), 1.0) << "not pressed into the concave edge, opening " << opening;
    for (int i = 0; i < 600; ++i) felt = proxy->step({.p_SD = Vec3(0, 0.02, -0.03 + 1e-4 * i)});
    EXPECT_LE(std::fabs(felt.force_n.z()), 1e-3) << "it sticks along the concave edge, opening " << opening;
    EXPECT_NEAR(felt.p_SP.y(), 0.03, 1e-6);
    for (int i = 0; i < 400; ++i) felt = proxy->step({.p_SD = Vec3(0, 0.02 + 2e-4 * i, 0.03)});
    EXPECT_FALSE(felt.contact);
  }
}

// The device goes straight down in the plane of a side. At the upper edge the proxy is at its largest distance, in unstable balance.
TEST(Proxy, DoesNotBalanceOnAnEdge) {
  for (const double radius : {0.0, 0.003}) {
    const auto proxy = proxy_over(scene_of(make_box({0.1, 0.1, 0.1}, 4)), radius);
    const Vec3 to(0.05, -0.01, 0.0031);
    const MethodOutput felt = press(*proxy, {0.05, 0.06, 0.0031}, to, 30);
    EXPECT_NEAR((felt.p_SP - to).norm(), radius, 1e-9) << "radius " << radius;
  }
}

// The same over a convex edge: the closest point is on one of the slopes.
TEST(Proxy, DoesNotBalanceOnAConvexEdge) {
  const double slope = std::numbers::pi / 6.0;
  const double height = 0.05 * std::tan(slope);
  const TriangleMesh roof = make_prism({{-0.05, 0.0}, {0.05, 0.0}, {0.0, height}}, 0.1, 4);
  Box bounds;
  for (const Vec3& v : roof.vertices) bounds.grow(v);
  const Vec3 edge =
      *std::max_element(roof.vertices.begin(), roof.vertices.end(), [](const Vec3& a, const Vec3& b) { return a.y() < b.y(); });
  const double z = bounds.centre().z() + 0.0017;
  const double depth = 0.01;
  const auto proxy = proxy_over(scene_of(roof));
  const MethodOutput felt = press(*proxy, {edge.x(), height + 0.01, z}, {edge.x(), height - depth, z}, 20);
  EXPECT_NEAR(felt.force_n.norm(), 1000.0 * depth * std::cos(slope), 1e-6);
}

TEST(Proxy, TheWorkOfAStepIsBoundedInAnyGeometry) {
  TriangleMesh fan;
  constexpr int kSlivers = 5000;
  fan.vertices.push_back(Vec3::Zero());
  for (int i = 0; i <= kSlivers; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kSlivers;
    fan.vertices.emplace_back(0.05 * std::cos(angle), 0.05 * std::sin(angle), 0.002 * std::sin(40.0 * angle));
  }
  for (std::uint32_t i = 1; i <= kSlivers; ++i) fan.triangles.push_back({0, i, i + 1});
  const auto proxy = proxy_over(scene_of(fan));
  proxy->reset({0.0, 0.0, 0.01});
  for (int i = 0; i < 50; ++i) {
    const auto before = proxy->swept().counters().sweeps;
    const double turn = 0.7 * i;
    const MethodOutput felt = proxy->step({.p_SD = {0.02 * std::cos(turn), 0.02 * std::sin(turn), i % 5 == 0 ? 0.003 : -0.004}});
    EXPECT_TRUE(felt.force_n.allFinite());
    EXPECT_LE(proxy->swept().counters().sweeps - before, 2U * (SweptMotion::kMaxMotions + 1U));
  }
}

TEST(Proxy, LongSlidesOnSharedEdgesStayOutside) {
  // A slide of centimetres in one step, exactly along edges: the contact normal's rounding alone would move the proxy through.
  TriangleMesh wedge = make_gutter(0.1, 0.02, 1.5, 20);
  const auto proxy = proxy_over(scene_of(wedge));
  for (const double turn : {0.0, 1e-17, 1e-16, -1e-16}) {
    for (int i = 0; i < 100; ++i) {
      proxy->reset({0.0004 * i * turn, 0.08, turn});
      const MethodOutput felt = proxy->step({.p_SD = Vec3(0.0002 * i, 0.0275, turn)});
      ASSERT_TRUE(felt.contact) << i;
      const MethodOutput again = proxy->step({.p_SD = Vec3(0.0002 * i, 0.0275, turn)});
      EXPECT_LE((felt.force_n - again.force_n).norm(), 1e-5 * felt.force_n.norm());
      EXPECT_LE(felt.force_n.norm(), 1000.0 * 0.02);
    }
  }
}

TEST(Proxy, BadInputGivesNoForceAndIsForgotten) {
  const auto proxy = proxy_over(scene_of(make_plane_grid(0.1, 4)));
  proxy->reset({0, 0, 0.001});
  const MethodOutput before = proxy->step({.p_SD = Vec3(0, 0, -0.001)});
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    const MethodOutput felt = proxy->step({.p_SD = Vec3(bad, 0, 0)});
    EXPECT_EQ(felt.force_n, Vec3(Vec3::Zero()));
    EXPECT_FALSE(felt.contact);
  }
  EXPECT_EQ(proxy->step({.p_SD = Vec3(0, 0, -0.001)}).force_n, before.force_n);
}

TEST(Proxy, AfterAnAbsurdlyFarDeviceTheSurfaceIsStillFelt) {
  const auto proxy = proxy_over(scene_of(make_icosphere(0.05, 3)));
  proxy->reset({0, 0, 0.08});
  for (const double far : {1e6, 1e30, 1e150, 1e300, -1e300}) {
    const MethodOutput there = proxy->step({.p_SD = Vec3(far, 0, std::fabs(far))});
    EXPECT_TRUE(there.force_n.allFinite());
    proxy->step({.p_SD = Vec3(0, 0, 0.08)});
    proxy->step({.p_SD = Vec3(0, 0, 0.0501)});
    EXPECT_TRUE(proxy->step({.p_SD = Vec3(0, 0, 0.048)}).contact) << "after " << far;
    proxy->step({.p_SD = Vec3(0, 0, 0.08)});
  }
}

TEST(Proxy, FreeStepsAreSkipped) {
  const auto proxy = proxy_over(scene_of(make_icosphere(0.05, 5)));
  proxy->reset({0, 0, 0.08});
  for (int i = 0; i < 1000; ++i) EXPECT_FALSE(proxy->step({.p_SD = Vec3(0, 0, 0.08 - 1e-5 * i)}).contact);
  EXPECT_GT(proxy->counters().skipped, 700U);
}

// The device is free in front of a sheet, goes round its boundary in large steps, and back through it to a position known to be free.
TEST(Proxy, ASheetIsNotCrossedToAPositionKnownToBeFree) {
  const auto proxy = proxy_over(scene_of(make_plane_grid(0.1, 4)));
  const std::uint64_t seed = 5;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> inside(-0.03, 0.03);
  std::uniform_real_distribution<double> height(0.01, 0.2);
  std::uniform_real_distribution<double> round(0.06, 1.0);
  for (int n = 0; n < 2000; ++n) {
    const Vec3 over(inside(random), inside(random), height(random));
    const Vec3 under(over.x(), over.y(), -height(random));
    const double far = round(random);
    proxy->reset(over + Vec3(0, 0, height(random)));
    for (const Vec3& device : {over, Vec3(far, over.y(), over.z()), Vec3(far, over.y(), under.z()), under}) {
      ASSERT_FALSE(proxy->step({.p_SD = device}).contact) << n;
    }
    ASSERT_TRUE(proxy->step({.p_SD = over}).contact) << n;
  }
}

TEST(Proxy, StepsUseNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "allocations cannot be counted in this build";
  const auto proxy = proxy_over(scene_of(make_bumpy_sphere(0.05, 0.08, 20000, 4)));
  const std::vector<Vec3> path = path_around_ball(0.05, 0.002, 3000);
  proxy->reset(path[0]);
  double sum = 0.0;
  const AllocationGuard guard;
  for (const Vec3& p : path) sum += proxy->step({.p_SD = p}).force_n.norm();
  proxy->reset(path[0]);
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_GT(sum, 0.0);
}

// The most important comparison: the method against the reference, on a walk over a rough closed mesh.
TEST(Proxy, FollowsTheReferenceOverAMesh) {
  const TouchScene scene = scene_of(make_bumpy_sphere(0.05, 0.05, 8000, 21));
  const auto proxy = proxy_over(scene);
  const auto reference = ReferenceMethod::make(MethodSettings(), scene).value();
  const std::vector<Vec3> path = path_around_ball(0.05, 0.0025, 3000);
  proxy->reset(path[0]);
  reference->reset(path[0]);
  std::vector<double> errors;
  for (const Vec3& p : path) {
    const MethodOutput felt = proxy->step({.p_SD = p});
    const MethodOutput expected = reference->step({.p_SD = p});
    if (!expected.contact || expected.force_n.norm() < 1e-6) continue;
    errors.push_back((felt.force_n - expected.force_n).norm() / expected.force_n.norm());
  }
  ASSERT_GT(errors.size(), 1000U);
  std::sort(errors.begin(), errors.end());
  EXPECT_LE(errors[errors.size() / 2], 1e-5);
  EXPECT_LE(errors[errors.size() * 98 / 100], 1e-3);
}

TEST(Proxy, ShadingSmoothsTheDirectionAndKeepsTheMagnitude) {
  // A walk round a coarse sphere: the shaded force is closer to the sphere's radius than the facets' normals are.
  const TouchScene scene = scene_of(make_icosphere(0.05, 2));
  MethodSettings settings;
  settings.shading = 1.0;
  const auto smooth = ProxyMethod::make(settings, scene).value();
  const auto plain = proxy_over(scene);
  const std::vector<Vec3> path = path_around_ball(0.05, 0.002, 4000);
  smooth->reset(path[0]);
  plain->reset(path[0]);
  double smooth_error = 0.0;
  double plain_error = 0.0;
  for (const Vec3& p : path) {
    const MethodOutput s = smooth->step({.p_SD = p});
    const MethodOutput f = plain->step({.p_SD = p});
    EXPECT_EQ(s.p_SP, f.p_SP);
    EXPECT_NEAR(s.force_n.norm(), f.force_n.norm(), 1e-12);
    if (!f.contact) continue;
    smooth_error += (s.force_n.normalized() - s.p_SP.normalized()).squaredNorm();
    plain_error += (f.force_n.normalized() - f.p_SP.normalized()).squaredNorm();
  }
  EXPECT_LT(smooth_error, 0.1 * plain_error);
  EXPECT_NE(smooth->describe().find("force shading 1"), std::string::npos);
}

TEST(Proxy, ObjectsNeverApproachedAreNeverBuilt) {
  TouchScene scene = scene_of(make_icosphere(0.05, 3));
  scene.objects.push_back({std::make_shared<TriangleMesh>(scaled_and_moved(make_icosphere(0.05, 3), 1.0, Vec3(5, 0, 0))), {}});
  MethodSettings settings;
  settings.build_on_approach = true;
  const auto lazy = ProxyMethod::make(settings, scene).value();
  const auto eager = proxy_over(scene);
  lazy->reset({0, 0, 0.3});
  eager->reset({0, 0, 0.3});
  bool has_touched = false;
  for (int i = 0; i < 3000; ++i) {
    const Vec3 p(0, 0, 0.3 - 1e-4 * i);
    const MethodOutput felt = lazy->step({.p_SD = p});
    EXPECT_EQ(felt.force_n, eager->step({.p_SD = p}).force_n);
    has_touched |= felt.contact;
    lazy->prepare();
  }
  EXPECT_TRUE(has_touched);
  EXPECT_EQ(static_cast<const ProxyMethod&>(*lazy).geometry().built_count(), 1U);
}

}  // namespace
}  // namespace hapton
