#include "core/force/reference/reference_method.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>

#include "core/force/evaluation/stress_body.h"
#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_shapes.h"
#include "core/geometry/touch_trajectory.h"

namespace hapton {
namespace {

constexpr double kStiffness = 1000.0;

TouchScene scene_of(TriangleMesh mesh, Material material = {}) {
  TouchScene scene;
  scene.objects.push_back({std::make_shared<TriangleMesh>(std::move(mesh)), material});
  return scene;
}

std::unique_ptr<ReferenceMethod> reference_over(TriangleMesh mesh, double probe_radius_m = 0.0, Material material = {},
                                                bool prefilter = true, int substeps = 8) {
  MethodSettings settings;
  settings.name = "reference";
  settings.probe_radius_m = probe_radius_m;
  settings.reference_substeps = substeps;
  auto made = ReferenceMethod::make_reference(settings, scene_of(std::move(mesh), material), prefilter);
  EXPECT_TRUE(made.has_value());
  return std::move(*made);
}

// A walk of the device near a shape: seeded, about 0.1 mm a step, alternating between outside and inside.
template <class Visit>
void walk(std::uint64_t seed, int steps, const std::function<Vec3(double, double)>& surface, Visit visit) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  double u = 0.3, v = 0.7;
  for (int i = 0; i < steps; ++i) {
    u += 0.002 * normal(random);
    v += 0.002 * normal(random);
    visit(surface(u, v), i);
  }
}

// ---- Shapes made of exact faces: the force is the analytic one to rounding of the proxy's rest distance. ----

TEST(ReferenceMethod, PlaneGivesTheExactDepth) {
  auto method = reference_over(make_plane_grid(0.1, 16));
  method->reset(Vec3(0.0, 0.0, 0.005));
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  Vec3 device(0.0, 0.0, 0.001);
  for (int i = 0; i < 2000; ++i) {
    device += 1e-4 * Vec3(normal(random), normal(random), 0.0);
    device.x() = std::clamp(device.x(), -0.045, 0.045);
    device.y() = std::clamp(device.y(), -0.045, 0.045);
    device.z() = 0.0015 * std::sin(0.01 * i);
    const MethodOutput felt = method->step({.p_SD = device});
    const double expected = std::max(0.0, -device.z()) * kStiffness;
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
    ASSERT_NEAR(felt.force_n.z(), kStiffness * std::max(0.0, radius - device.z()), 1e-6) << i;
    ASSERT_LT(felt.force_n.head<2>().norm(), 1e-6);
  }
}

// Inside a box the free space is convex, so the proxy is the projection onto it: exact on faces, edges and corners, in one step.
TEST(ReferenceMethod, RoomCornersAreExactProjections) {
  for (double probe : {0.0, 0.002}) {
    auto method = reference_over(make_box(Vec3::Constant(0.1), 5), probe);
    method->reset(Vec3::Zero());
    std::mt19937_64 random(2);
    std::uniform_real_distribution<double> symmetric(-1.0, 1.0);
    Vec3 before_force = Vec3::Zero(), before = Vec3::Zero();
    for (int i = 0; i < 1500; ++i) {
      const Vec3 device = 0.06 * Vec3(symmetric(random), symmetric(random), symmetric(random));
      const Vec3 expected = device.cwiseMax(-0.05 + probe).cwiseMin(0.05 - probe);
      const MethodOutput felt = method->step({.p_SD = device});
      ASSERT_LT((felt.p_SP - expected).norm(), 1e-9) << i << " probe " << probe;
      ASSERT_LT((felt.force_n - kStiffness * (expected - device)).norm(), 1e-6);
      ASSERT_LE((felt.force_n - before_force).norm(), kStiffness * (device - before).norm() + 1e-6);  // firmly non-expansive
      before_force = felt.force_n;
      before = device;
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
        expected[axis] = side * kStiffness * std::max(0.0, 0.05 - std::abs(device[axis]));
        ASSERT_LT((felt.force_n - expected).norm(), 1e-6) << axis << ' ' << i;
      }
    }
  }
}

// ---- Curved shapes: the mesh lies inside the shape by at most the sagitta, and its normals differ by at most the facet's half angle. ----

struct Curved {
  const char* name;
  TriangleMesh mesh;
  std::function<Vec3(double, double)> at_depth_1mm;
  std::function<Vec3(const Vec3&)> nearest;  // on the analytic surface
  double sagitta_m;                          // the farthest the mesh is from the surface
  double tilt_rad;                           // the farthest a face's normal is from the surface's
  double least_radius_m;                     // of curvature, at the device's depth: how a tilt of the face moves the foot
};

void expect_close_to_analytic(const Curved& shape, double probe) {
  auto method = reference_over(shape.mesh, probe);
  const Vec3 first = shape.at_depth_1mm(0.3, 0.7);
  const Vec3 outwards = (shape.nearest(first) - first).normalized();
  method->reset(first + 0.01 * outwards);
  method->step({.p_SD = first});
  int contacts = 0;
  walk(9, 1500, shape.at_depth_1mm, [&](const Vec3& device, int i) {
    const MethodOutput felt = method->step({.p_SD = device});
    const Vec3 depth = shape.nearest(device) - device;
    const Vec3 expected = kStiffness * (depth + probe * depth.normalized());
    // The nearest point of the mesh is within the sagitta of the shape's along the depth. Sideways the foot rests on a face that is
    // tilted by at most tilt, so the force is turned by at most that angle.
    const double strength = expected.norm();
    ASSERT_TRUE(felt.contact) << shape.name << ' ' << i;
    ASSERT_NEAR(felt.force_n.norm(), strength, kStiffness * shape.sagitta_m + strength * 0.5 * shape.tilt_rad * shape.tilt_rad + 1e-6)
        << shape.name << ' ' << i;
    ASSERT_LT((felt.force_n - expected).norm(), kStiffness * shape.sagitta_m + strength * 1.05 * shape.tilt_rad + 1e-6)
        << shape.name << ' ' << i;
    ++contacts;
  });
  EXPECT_EQ(contacts, 1500);
  EXPECT_EQ(method->counters().proxy.unconverged, 0u) << shape.name;
}

// The longest edge e of a face inscribed in radius r: the face's circumradius is at most e / sqrt(3) for near-equilateral faces and e / 2
// for right ones in their plane; e / sqrt(3) bounds both.
double longest_edge(const TriangleMesh& mesh) {
  double longest = 0.0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (int k = 0; k < 3; ++k) longest = std::max(longest, (mesh.corner(i, k) - mesh.corner(i, (k + 1) % 3)).norm());
  }
  return longest;
}

Curved make_sphere_case() {
  const double r = 0.05;
  TriangleMesh mesh = make_icosphere(r, 6);
  const double reach = longest_edge(mesh) / std::sqrt(3.0);
  return {"sphere",
          std::move(mesh),
          [=](double u, double v) { return Vec3((r - 0.001) * Vec3(std::cos(u) * std::cos(v), std::sin(u) * std::cos(v), std::sin(v))); },
          [=](const Vec3& p) { return Vec3(r * p.normalized()); },
          r - std::sqrt(r * r - reach * reach),
          std::asin(reach / r),
          r - 0.001};
}

Curved make_cylinder_case() {
  const double r = 0.03;
  const int sides = 256;
  return {"cylinder",
          make_cylinder(r, 0.1, sides, 40),
          [=](double u, double v) { return Vec3((r - 0.001) * std::cos(u), (r - 0.001) * std::sin(u), 0.03 * std::sin(v)); },
          [=](const Vec3& p) {
            const double across = p.head<2>().norm();
            return Vec3(p.x() * r / across, p.y() * r / across, p.z());
          },
          r * (1.0 - std::cos(std::numbers::pi / sides)),
          std::numbers::pi / sides,
          r - 0.001};
}

Curved make_torus_case() {
  const double ring = 0.035, tube = 0.015;
  const int around = 512, about = 192;
  // Two chords, one along each circle: their sagittas add, their half angles too.
  const double step_tube = std::numbers::pi / about, step_ring = std::numbers::pi / around;
  return {"torus",
          make_torus(ring, tube, around, about),
          [=](double u, double v) {
            const double out = ring + (tube - 0.001) * std::cos(v);
            return Vec3(out * std::cos(u), out * std::sin(u), (tube - 0.001) * std::sin(v));
          },
          [=](const Vec3& p) {
            const Vec3 core = ring * Vec3(p.x(), p.y(), 0.0).normalized();
            return Vec3(core + tube * (p - core).normalized());
          },
          (ring + tube) * (1.0 - std::cos(step_ring)) + tube * (1.0 - std::cos(step_tube)),
          1.5 * (step_tube + step_ring),
          tube - 0.001};
}

TEST(ReferenceMethod, SphereWithinTheSagitta) { expect_close_to_analytic(make_sphere_case(), 0.0); }
TEST(ReferenceMethod, CylinderWithinTheSagitta) { expect_close_to_analytic(make_cylinder_case(), 0.0); }
TEST(ReferenceMethod, TorusWithinTheSagitta) { expect_close_to_analytic(make_torus_case(), 0.0); }
TEST(ReferenceMethod, SphereProbeOnASphere) { expect_close_to_analytic(make_sphere_case(), 0.0005); }
TEST(ReferenceMethod, SphereProbeOnATorus) { expect_close_to_analytic(make_torus_case(), 0.002); }

// A sphere over an edge it can roll about: on a tetrahedron-like ridge the rest place is analytic.
TEST(ReferenceMethod, SphereProbeRollsAboutAnOpenEdge) {
  // A half plane z = 0, x <= 0: its border is the y axis. A sphere of radius r hangs on it where the device pulls it.
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
}

// ---- Places and motions that must not leak. ----

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
      ASSERT_NEAR(felt.force_n.norm(), kStiffness * 0.03 * aim.norm(), 0.1);
      ASSERT_GT(felt.p_SP.norm(), 0.0485);
    }
  }
}

TEST(ReferenceMethod, CoincidentSweepsStayOutside) {
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
  EXPECT_NEAR(felt.force_n.z(), 10.0 + kStiffness * 5e-6, 1e-6);
  EXPECT_NEAR(felt.p_SP.z(), 5e-6, 1e-10);
}

TEST(ReferenceMethod, OneSidedSurfaceLetsGoFromBehind) {
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

// A fold straight along z whose walls come closer together from z = 0 on, and bend aside. A point runs along its ground without a step; a
// sphere, however small, would have to climb at the corner, by a share of its own radius.
TEST(ReferenceMethod, ANarrowingFoldDoesNotHoldAPoint) {
  TriangleMesh fold;
  fold.vertices = {{0, 0, -0.05},        {0, 0, 0},        {0, 0, 0.05},       {0.03, 0.02, -0.05}, {0.03, 0.02, 0}, {0.012, 0.02, 0.05},
                   {-0.03, 0.02, -0.05}, {-0.03, 0.02, 0}, {-0.02, 0.02, 0.05}};
  fold.triangles = {{0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}, {0, 6, 7}, {0, 7, 1}, {1, 7, 8}, {1, 8, 2}};
  for (const double turn : {0.0, 1.0}) {
    TriangleMesh turned = fold;
    const Mat3 X = Eigen::AngleAxisd(turn, Vec3(1, 2, 3).normalized()).toRotationMatrix();
    for (Vec3& vertex : turned.vertices) vertex = X * vertex;
    auto method = reference_over(turned);
    method->reset(X * Vec3(0.0, 0.005, -0.03));
    for (int i = 0; i <= 300; ++i) {
      const Vec3 device(0.0, -0.002, -0.03 + 0.0002 * i);
      const MethodOutput felt = method->step({.p_SD = X * device});
      ASSERT_LT((felt.p_SP - X * Vec3(0.0, 0.0, device.z())).norm(), 1e-9) << i;
    }
  }
}

// ---- Invariances. ----

TEST(ReferenceMethod, SameForceAtEveryScaleAndPlace) {
  const TriangleMesh mesh = make_bumpy_sphere(0.5, 0.2, 1000, 4);
  std::vector<Vec3> path;
  walk(
      10, 300,
      [](double u, double v) {
        return Vec3(0.47 * Vec3(std::cos(20 * u) * std::cos(20 * v), std::sin(20 * u) * std::cos(20 * v), std::sin(20 * v)));
      },
      [&](const Vec3& p, int) { path.push_back(p); });
  auto run = [&](double scale, const Vec3& move) {
    auto method = reference_over(scaled_and_moved(mesh, scale, move));
    method->reset(2.0 * path.front() * scale + move);
    std::vector<Vec3> stretches;
    for (const Vec3& p : path) {
      const Vec3 device = p * scale + move;
      stretches.push_back(method->step({.p_SD = device}).force_n / (kStiffness * scale));
    }
    return stretches;
  };
  const std::vector<Vec3> plain = run(1.0, Vec3::Zero());
  for (const auto& [scale, move, play] : {std::tuple{1e-6, Vec3(0, 0, 0), 1e-8},
                                          {1e6, Vec3(0, 0, 0), 1e-8},
                                          {1.0, Vec3(1e6, -1e6, 1e6), 1e-6},
                                          {0x1p-20, Vec3(0, 0, 0), 0.0}}) {
    const std::vector<Vec3> other = run(scale, move);
    int contacts = 0;
    for (std::size_t i = 0; i < plain.size(); ++i) {
      ASSERT_LE((plain[i] - other[i]).norm(), play) << scale << ' ' << i;
      contacts += plain[i].norm() > 0.0;
    }
    EXPECT_GT(contacts, 100);
  }
}

TEST(ReferenceMethod, PrefilterChangesNothingToTheBit) {
  for (double probe : {0.0, 0.003}) {
    const TriangleMesh mesh = make_bumpy_sphere(0.05, 0.25, 1000, 5);
    auto with = reference_over(mesh, probe, {}, true);
    auto without = reference_over(mesh, probe, {}, false);
    std::mt19937_64 random(12);
    std::normal_distribution<double> normal;
    Vec3 device(0.07, 0.0, 0.0);
    with->reset(device);
    without->reset(device);
    int contacts = 0;
    for (int i = 0; i < 250; ++i) {
      device +=
          (i % 17 == 0 ? 0.02 : 0.0015) * Vec3(normal(random), normal(random), normal(random)) - 0.05 * device * (device.norm() > 0.07);
      const MethodOutput one = with->step({.p_SD = device});
      const MethodOutput two = without->step({.p_SD = device});
      ASSERT_EQ(one.force_n, two.force_n) << i;
      ASSERT_EQ(one.p_SP, two.p_SP) << i;
      contacts += one.contact;
    }
    EXPECT_GT(contacts, 50);
    EXPECT_LT(with->counters().candidates, without->counters().candidates);
  }
}

// ---- Materials. ----

TEST(ReferenceMethod, FrictionHoldsInsideTheConeAndDragsOnIt) {
  Material material;
  material.friction_static = 0.5;
  material.friction_dynamic = 0.3;
  auto method = reference_over(make_plane_grid(0.1, 10), 0.0, material);
  method->reset(Vec3(0.0, 0.0, 0.001));
  method->step({.p_SD = Vec3(0.0, 0.0, -0.001)});
  bool slid = false;
  for (int i = 1; i <= 200; ++i) {
    const double x = 1e-5 * i;
    const Vec3 force = method->step({.p_SD = Vec3(x, 0.0, -0.001)}).force_n;
    const double ratio = -force.x() / force.z();
    ASSERT_LE(ratio, 0.5 + 1e-6);
    if (x < 0.00049) {
      ASSERT_NEAR(force.x(), -kStiffness * x, 1e-6) << i;
    } else if (x > 0.00052) {
      slid = true;
      ASSERT_NEAR(ratio, 0.3, 1e-6) << i;
    }
  }
  EXPECT_TRUE(slid);
}

TEST(ReferenceMethod, DampingResistsGoingInAndNeverPulls) {
  Material material;
  material.damping_ns_per_m = 2.0;
  auto method = reference_over(make_plane_grid(0.1, 4), 0.0, material);
  method->reset(Vec3(0.0, 0.0, 0.001));
  method->step({.p_SD = Vec3(0.0, 0.0, -0.001)});
  EXPECT_NEAR(method->step({.p_SD = Vec3(0.0, 0.0, -0.0011)}).force_n.z(), 1.1 + 0.2, 1e-6);
  EXPECT_NEAR(method->step({.p_SD = Vec3(0.0, 0.0, -0.0010)}).force_n.z(), 1.0 - 0.2, 1e-6);
  EXPECT_EQ(method->step({.p_SD = Vec3(0.0, 0.0, -0.00001)}).force_n.z(), 0.0);
}

// ---- The limit of ever finer sub-steps. ----

std::unique_ptr<ReferenceMethod> limit_over(TriangleMesh mesh, int substeps, int limit, Material material = {}) {
  MethodSettings settings;
  settings.reference_substeps = substeps;
  settings.reference_substep_limit = limit;
  auto made = ReferenceMethod::make_reference(settings, scene_of(std::move(mesh), material));
  EXPECT_TRUE(made.has_value());
  return std::move(*made);
}

TriangleMesh box_between(const Vec3& low, const Vec3& high) { return scaled_and_moved(make_box(high - low), 1.0, 0.5 * (low + high)); }

// A block with its top in y = 0 and its right side in x = 0; a shelf beside it, below the top, that leaves a gap.
TriangleMesh block_and_shelf(double gap) {
  return joined(box_between({-0.1, -0.1, -0.05}, {0.0, 0.0, 0.05}), box_between({gap, -0.020, -0.05}, {0.03, -0.016, 0.05}));
}

constexpr double kLeap = 0.02;   // of the device in one step, along x
constexpr double kDepth = 0.04;  // below the top of the block, and below the shelf
// Let go in 8 sub-steps the proxy passes the foot of the shelf by (0.625 - 0.53) / 2 of the leap: too far. In 16 by (0.5625 - 0.53) / 2.
constexpr double kGap = 0.025 * kLeap;

// The device crosses the side of the block at the share `at` of its step. There the proxy, held above it on the edge, is let go, falls
// straight to the device through the gap, and is free from then on. Sub-steps too long have it fall on the shelf.
ReferenceStep leap(ReferenceMethod& method, double at, MethodOutput& felt) {
  method.reset(Vec3(-at * kLeap, 0.001, 0.0));
  method.step({.p_SD = Vec3(-at * kLeap, -kDepth, 0.0)});
  felt = method.step({.p_SD = Vec3((1.0 - at) * kLeap, -kDepth, 0.0)});
  return method.last_step();
}

TEST(ReferenceMethod, ReleasedAtAConvexEdgeInMidStepItConvergesToTheEvent) {
  const double gap = kGap;
  MethodOutput felt;
  const auto enough = limit_over(block_and_shelf(gap), 8, 64);
  const ReferenceStep settled = leap(*enough, 0.53, felt);
  EXPECT_TRUE(settled.settled);
  EXPECT_EQ(settled.substeps, 32);
  EXPECT_FALSE(felt.contact);
  EXPECT_EQ(felt.p_SP, Vec3(0.47 * kLeap, -kDepth, 0.0));
  EXPECT_EQ(enough->counters().unsettled_steps, 0u);
}

TEST(ReferenceMethod, WhatDiffersAtTheLimitOfSubStepsHasNotSettled) {
  MethodOutput felt;
  const auto short_of = limit_over(block_and_shelf(kGap), 8, 16);
  const ReferenceStep step = leap(*short_of, 0.53, felt);
  EXPECT_FALSE(step.settled);
  EXPECT_EQ(step.substeps, 16);
  EXPECT_GT(step.change, 0.1);
  EXPECT_EQ(short_of->counters().unsettled_steps, 1u);
  EXPECT_NE(short_of->describe().find("1 not settled"), std::string::npos) << short_of->describe();
}

// The shelf is divided by plates, each half as far from the block as the next: each halving of the sub-step falls into another division.
TEST(ReferenceMethod, AChaoticStepIsReportedNotSettled) {
  TriangleMesh mesh = block_and_shelf(1e-6);
  for (double x = 0.71 * kLeap; x > 1e-5; x *= 0.5) {
    mesh = joined(mesh, box_between({x, -0.018, -0.05}, {1.05 * x, -0.012, 0.05}));
  }
  MethodOutput felt;
  const auto method = limit_over(mesh, 2, 512);
  const ReferenceStep step = leap(*method, 0.5 + 1e-5, felt);
  EXPECT_FALSE(step.settled);
  EXPECT_EQ(step.substeps, 512);
  EXPECT_GT(step.change, 1e-6);
  EXPECT_TRUE(felt.contact);
}

// A gutter of two walls at 45 degrees. The device moves along x below it, and in mid-step the left wall's multiplier reaches zero: from
// there the proxy is the projection onto the right wall.
TEST(ReferenceMethod, ReleasedFromAConcaveEdgeInMidStepItIsOnTheOtherWall) {
  for (const int substeps : {1, 3, 8, 32}) {
    const auto method = limit_over(make_gutter(0.1, 0.02, std::numbers::pi / 2.0, 2), substeps, 1024);
    const double apex = compute_bounds(make_gutter(0.1, 0.02, std::numbers::pi / 2.0, 2)).high.y() - 0.02;
    const double depth = 0.01;
    method->reset(Vec3(0.0, apex + 0.001, 0.0));
    method->step({.p_SD = Vec3(0.002, apex - depth, 0.0)});
    const MethodOutput felt = method->step({.p_SD = Vec3(0.016, apex - depth, 0.0)});  // let go at x = depth
    // The right wall rises as (1, 1) / sqrt 2: its height over the apex is the mean of x and y.
    const double along = 0.5 * (0.016 - depth);
    EXPECT_LT((felt.force_n / kStiffness - Vec3(along - 0.016, along + depth, 0.0)).norm(), 1e-12) << substeps;
    EXPECT_TRUE(method->last_step().settled);
    EXPECT_EQ(method->last_step().substeps, 2 * substeps);
  }
}

// Inside a prism of eight sides the proxy stays on its face until the device's projection passes an edge, however near the next face is.
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
    EXPECT_LT((method->step({.p_SD = device}).force_n / kStiffness + device - expected).norm(), 1e-12) << i;
    EXPECT_TRUE(method->last_step().settled) << i;
  }
}

// Dragged over a plane by a device that turns, the proxy follows tractrices; their length in sub-steps does not matter.
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
    method->step({.p_SD = Vec3(0.0, 0.001, -depth)});  // slides: the lag is the cone, along x
    const MethodOutput felt = method->step({.p_SD = Vec3(0.0, 0.001 + 2.0 * cone, -depth)});
    const Vec3 lag(cone / std::cosh(2.0), cone * std::tanh(2.0), -depth);  // of the proxy behind the device
    EXPECT_LT((felt.force_n / kStiffness + lag).norm(), 1e-12);
    EXPECT_TRUE(method->last_step().settled);
  }
}

TEST(ReferenceMethod, APointsRadiusIsTakenOffAgain) {
  const auto method = reference_over(make_plane_grid(0.1, 4));
  method->reset(Vec3(0.001, 0.002, 0.001));
  const MethodOutput felt = method->step({.p_SD = Vec3(0.001, 0.002, -0.001)});
  EXPECT_NEAR(felt.force_n.z(), kStiffness * 0.001, 1e-13);
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
  second->resume(sliding.p_SP, device, true);
  for (int i = 1; i < 20; ++i) {
    const Vec3 next = device + Vec3(2e-5 * i, 5e-5 * i, 1e-6 * i);
    EXPECT_LT((first->step({.p_SD = next}).force_n - second->step({.p_SD = next}).force_n).norm(), 1e-9) << i;
  }
  second->resume(Vec3(0.0, 0.0, 0.01), Vec3(0.0, 0.0, 0.01), false);
  EXPECT_FALSE(second->step({.p_SD = Vec3(0.0, 0.0, 0.005)}).contact);
}

// Slides under friction over bumps sharper than the touch is deep, every step compared with the proxy, which goes by other code. Before the
// reference went by the steepest way at a vertex, stood on both faces of a concave edge and halved the sub-steps in which friction lets it
// slip, it differed by up to 158 % of the force, and by more than 1e-6 in one of 90 steps.
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
    int far = 0;
    for (std::size_t i = 0; i < slide->p_SD.size(); ++i) {
      const Vec3& device = slide->p_SD[i];
      if (i == 0) {
        reference->reset(device);
        (*proxy)->reset(device);
      }
      const Vec3 expected = reference->step({.p_SD = device}).force_n;
      const Vec3 felt = (*proxy)->step({.p_SD = device}).force_n;
      const double share = (felt - expected).norm() / std::max(expected.norm(), 1e-3);
      ASSERT_LT(share, 1e-3) << "seed " << seed << ", row " << i;
      contacts += expected.norm() > 0.0;
      far += share > 1e-5;
    }
    EXPECT_GT(contacts, 400);
    EXPECT_LT(far, contacts / 50) << "seed " << seed;
  }
}

// ---- The judge of rest. ----

TEST(ReferenceMethod, SettleFromMovesWhatWasNotAtRest) {
  auto method = reference_over(make_plane_grid(0.1, 4));
  const MethodOutput rested = method->settle_from(Vec3(0.001, 0.002, 0.0), Vec3(0.001, 0.002, -0.001));
  EXPECT_LT((rested.p_SP - Vec3(0.001, 0.002, 0.0)).norm(), 1e-9);
  const MethodOutput moved = method->settle_from(Vec3(0.011, 0.002, 1e-10), Vec3(0.001, 0.002, -0.001));
  EXPECT_LT((moved.p_SP - Vec3(0.001, 0.002, 0.0)).norm(), 1e-9);
}

// In the groove between two spikes of a star, just below its end, with the device beyond and a little lower: the groove holds it. The edges
// between the triangles of a wall lean along the groove by more than the device draws.
TEST(ReferenceMethod, EdgesWithinAWallDoNotHoldWhatSlidesAlongIt) {
  const double extent = compute_bounds(make_stress_body("star").touched).extent();
  const double inner = 0.12 * 0.1;
  const double angle = 0.6 * std::numbers::pi;
  for (const double offset : {0.0, 10.0, 1000.0}) {  // far away the triangles of a wall are in one plane only to rounding
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

TEST(ReferenceMethod, RefusesImpossibleSettings) {
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
