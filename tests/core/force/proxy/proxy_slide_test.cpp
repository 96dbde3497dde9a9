#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "core/force/evaluation/force_error.h"
#include "core/force/proxy/proxy_method.h"
#include "core/force/reference/reference_method.h"
#include "core/geometry/closest_point.h"
#include "core/geometry/mesh_shapes.h"
#include "tests/support/made_scene.h"

namespace hapton {
namespace {

std::unique_ptr<ProxyMethod> point_over(const TouchScene& scene) {
  auto made = ProxyMethod::make(MethodSettings(), scene);
  return std::unique_ptr<ProxyMethod>(static_cast<ProxyMethod*>(made.value().release()));
}

// A path around a sphere of 50 mm that climbs up and down, at a hand's speed, 2 mm below the surface.
std::vector<Vec3> slide_path(int steps) {
  std::vector<Vec3> path;
  for (int i = 0; i < steps; ++i) {
    const double turn = 2.0 * std::numbers::pi * i / 3000.0;
    const Vec3 out(std::cos(turn), std::sin(turn), 0.4 * std::sin(2.3 * turn));
    path.push_back(out.normalized() * (0.05 + (i < 30 ? 0.0003 * (20 - i) : -0.002)));
  }
  return path;
}

std::vector<ForceSample> feel(ForceMethod& method, const std::vector<Vec3>& path, double scale = 1.0, const Vec3& offset = Vec3::Zero()) {
  std::vector<ForceSample> felt;
  method.reset(scale * path[0] + offset);
  for (const Vec3& p : path) {
    const MethodOutput out = method.step({.p_SD = scale * p + offset});
    felt.push_back({p, (out.p_SP - offset) / scale, out.force_n / scale});
  }
  return felt;
}

TEST(ProxySlide, NoStepOfASlideNeedsASweepAndAllAgreeWithTheReference) {
  const TouchScene scene = scene_of(make_bumpy_sphere(0.05, 0.08, 20000, 12));
  const std::vector<Vec3> path = slide_path(1500);
  const auto proxy = point_over(scene);
  const std::vector<ForceSample> felt = feel(*proxy, path);
  const ProxyCounters& counters = proxy->counters();
  EXPECT_GT(counters.contact_steps, path.size() * 7 / 10);
  EXPECT_EQ(counters.swept, 0U);
  EXPECT_EQ(proxy->swept().counters().sweeps, 0U);

  const std::vector<ForceSample> expected = feel(*ReferenceMethod::make(MethodSettings(), scene).value(), path);
  std::size_t different_steps = 0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    EXPECT_EQ(felt[i].force_n.isZero(0.0), expected[i].force_n.isZero(0.0)) << "step " << i;
    const double force_n = std::max(expected[i].force_n.norm(), 0.5);
    different_steps += (felt[i].force_n - expected[i].force_n).norm() > 1e-6 * force_n ? 1 : 0;
  }
  EXPECT_EQ(different_steps, 0U);
}

TEST(ProxySlide, NeitherScaleNorPlaceChangesTheForces) {
  const TriangleMesh mesh = make_bumpy_sphere(0.05, 0.08, 20000, 12);
  const std::vector<Vec3> path = slide_path(1500);
  const auto proxy = point_over(scene_of(mesh));
  const std::vector<ForceSample> expected = feel(*proxy, path);
  struct Placement {
    double scale;
    Vec3 offset;
    double precision;  // of a position there, relative to the mesh's size
  };
  for (const auto& [scale, offset, precision] :
       {Placement{1e-6, Vec3::Zero(), 1e-15}, Placement{1e6, Vec3::Zero(), 1e-15}, Placement{1.0, Vec3(300.0, -200.0, 100.0), 1e-12}}) {
    SCOPED_TRACE(testing::Message() << "scale " << scale << ", at " << offset.transpose());
    const auto placed = point_over(scene_of(scaled_and_moved(mesh, scale, offset)));
    const std::vector<ForceSample> felt = feel(*placed, path, scale, offset);
    std::size_t different_steps = 0;
    for (std::size_t i = 0; i < path.size(); ++i) {
      const double d = (felt[i].force_n - expected[i].force_n).norm() / (expected[i].force_n.norm() + 1e-9);
      different_steps += d > 1e4 * precision + 1e-8 ? 1 : 0;
    }
    EXPECT_EQ(different_steps, 0U);
    EXPECT_EQ(placed->counters().contact_steps, proxy->counters().contact_steps);
  }
}

// Both methods drag the proxy along a tractrix: the reference in sub-steps, each on one plane, `proxy` from event to event.
TEST(ProxySlide, WithFrictionTheForceIsThatOfTheReference) {
  Material rough;
  rough.friction_static = 0.5;
  rough.friction_dynamic = 0.4;
  const TouchScene scene = scene_of(make_bumpy_sphere(0.05, 0.08, 20000, 12), rough);
  const std::vector<Vec3> path = slide_path(1500);
  const auto proxy = point_over(scene);
  const std::vector<ForceSample> felt = feel(*proxy, path);
  EXPECT_EQ(proxy->counters().swept, 0U);
  EXPECT_EQ(proxy->counters().exhausted, 0U);
  const std::vector<ForceSample> expected = feel(*ReferenceMethod::make(MethodSettings(), scene).value(), path);
  double sum_of_squares = 0.0;
  std::size_t contacts = 0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    EXPECT_EQ(felt[i].force_n.isZero(0.0), expected[i].force_n.isZero(0.0)) << "step " << i;
    if (expected[i].force_n.isZero(0.0)) continue;
    ++contacts;
    sum_of_squares += (felt[i].force_n - expected[i].force_n).squaredNorm() / expected[i].force_n.squaredNorm();
  }
  EXPECT_LE(std::sqrt(sum_of_squares / static_cast<double>(contacts)), 0.02);
}

// By how much, N, the pull of the device along the surface exceeds what friction holds: negative within the cone, -infinity if the proxy is
// at no triangle. On each triangle at the proxy, the pull is the force's projection on the directions that lead onto the triangle, by brute
// force.
double force_out_of_cone(const TriangleMesh& mesh, const MethodOutput& felt, double mu, double reach_m) {
  constexpr double kMetresPerNewton = 1e-6;  // a thousandth of the depth, so that each projection is within a triangle or at its edge
  double most_n = -std::numeric_limits<double>::infinity();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 a = mesh.corner(t, 0);
    const Vec3 b = mesh.corner(t, 1);
    const Vec3 c = mesh.corner(t, 2);
    if (((a.cwiseMin(b).cwiseMin(c) - felt.p_SP).array() > reach_m).any()) continue;
    if (((felt.p_SP - a.cwiseMax(b).cwiseMax(c)).array() > reach_m).any()) continue;
    const ClosestPoint here = closest_point(a, b, c, felt.p_SP);
    if (here.distance > reach_m) continue;
    const ClosestPoint pulled = closest_point(a, b, c, here.point - kMetresPerNewton * felt.force_n);
    const Vec3 pull_n = (pulled.point - here.point) / kMetresPerNewton;
    most_n = std::max(most_n, pull_n.norm() - mu * (felt.force_n + pull_n).norm());
  }
  return most_n;
}

// The device turns back now and then, so that the proxy sticks there until static friction no longer holds it.
TEST(ProxySlide, NoForceIsOutsideItsFrictionCone) {
  const TriangleMesh bumps = make_bumpy_sphere(0.05, 0.08, 20000, 12);
  const std::vector<Vec3> path = slide_path(1500);
  for (const auto& [static_mu, dynamic_mu] : {std::pair(0.5, 0.4), std::pair(0.8, 0.2), std::pair(0.3, 0.3)}) {
    SCOPED_TRACE(testing::Message() << "friction " << static_mu << ", " << dynamic_mu);
    const Material rough = {.friction_static = static_mu, .friction_dynamic = dynamic_mu};
    const auto proxy = point_over(scene_of(bumps, rough));
    // The proxy is one contact offset off the surface, which the force leaves out: pull and normal force are off by at most that.
    const double offset_m = 0x1p-30 * proxy->geometry().unit_m();
    const double tolerance_n = rough.stiffness_n_per_m * offset_m * (1.0 + static_mu);
    int sticking_steps = 0;
    int sliding_steps = 0;
    proxy->reset(path[0]);
    std::size_t at = 0;
    for (int i = 0; at < path.size(); ++i, at += i % 120 < 100 ? 1 : -1) {
      const MethodOutput felt = proxy->step({.p_SD = path[at]});
      if (!felt.contact) continue;
      const bool slides = proxy->is_sliding();
      (slides ? sliding_steps : sticking_steps) += 1;
      const double out_n = force_out_of_cone(bumps, felt, slides ? dynamic_mu : static_mu, 2.0 * offset_m);
      ASSERT_TRUE(std::isfinite(out_n)) << "step " << i;
      ASSERT_LE(out_n, tolerance_n) << "step " << i;
    }
    EXPECT_GT(sticking_steps, 100);
    EXPECT_GT(sliding_steps, 500);
  }
}

// Vertices are numbered per object: a triangle with the same vertex numbers may be another object's.
TEST(ProxySlide, OverABoundaryItDoesNotStepOntoASimilarSheet) {
  const TriangleMesh sheet = make_plane_grid(0.1, 2);
  TriangleMesh turned = sheet;
  for (Vec3& v : turned.vertices) v = Vec3(0.08 - v.x(), v.y(), 0.002 - v.z());
  TouchScene scene = scene_of(sheet);
  scene.objects.push_back({std::make_shared<TriangleMesh>(turned), {}});
  const auto proxy = point_over(scene);
  for (double y = -0.043; y < 0.045; y += 0.01) {
    proxy->reset({0.04, y, 0.001});
    for (const double x : {0.04, 0.045, 0.049, 0.0505, 0.051}) {
      const MethodOutput felt = proxy->step({.p_SD = Vec3(x, y, -0.001)});
      EXPECT_EQ(felt.contact, x < 0.05) << "x " << x << " y " << y;
    }
  }
}

// An object built while the probe slides near it is active from then on, also when the triangles near it were gathered before.
TEST(ProxySlide, AnActivatedObjectIsTouchedAtOnce) {
  TouchScene scene = scene_of(make_plane_grid(0.1, 2));
  scene.objects.push_back({std::make_shared<TriangleMesh>(scaled_and_moved(make_box({0.01, 0.01, 0.01}), 1.0, {0.02, 0.0, 0.0})), {}});
  MethodSettings settings;
  settings.build_on_approach = true;
  const auto lazy = ProxyMethod::make(settings, scene).value();
  const auto eager = ProxyMethod::make(MethodSettings(), scene).value();
  const Vec3 start(-0.03, 0.001, 0.005);
  lazy->reset(start);
  while (lazy->prepare()) {
  }
  lazy->step({.p_SD = start - Vec3(0.0, 0.0, 0.001)});
  lazy->prepare();
  eager->reset(start);
  for (int i = 0; i < 100; ++i) {
    const Vec3 p(-0.03 + 5e-4 * i, 0.001, i == 0 ? 0.004 : -0.001);
    const MethodOutput felt = lazy->step({.p_SD = p});
    const MethodOutput expected = eager->step({.p_SD = p});
    EXPECT_LE((felt.force_n - expected.force_n).norm(), 1e-6) << "step " << i;
    while (i == 80 && lazy->prepare()) {
    }
  }
}

// A tap that ends exactly where it began: under friction the proxy stays where the device went in, and the device comes out through that
// very point, in or between two samples. On a face, an edge or a vertex, a saddle among them, it is free from there on.
TEST(ProxySlide, ADeviceThatLeavesThroughItsProxyIsFree) {
  constexpr int kSteps = 10;  // each way
  const TouchScene frictionless = scene_of(make_bumpy_sphere(0.045, 0.25, 5000, 3));
  const TriangleMesh& bumps = *frictionless.objects[0].mesh;
  std::vector<Vec3> normals(bumps.vertices.size(), Vec3::Zero());
  for (const auto& [a, b, c] : bumps.triangles) {
    const Vec3 normal = (bumps.vertices[b] - bumps.vertices[a]).cross(bumps.vertices[c] - bumps.vertices[a]);
    for (const std::uint32_t v : {a, b, c}) normals[v] += normal;
  }
  for (Vec3& normal : normals) normal.normalize();
  int taps = 0;
  for (const double friction : {0.0, 0.5}) {
    TouchScene scene = frictionless;
    scene.objects[0].material.friction_static = friction;
    scene.objects[0].material.friction_dynamic = 0.8 * friction;
    const auto proxy = point_over(scene);
    const auto tap = [&](const Vec3& p, const Vec3& out, double start_m) {
      const auto at = [&](int i) { return Vec3(p + (start_m - 0.0005 * i) * out); };
      proxy->reset(at(0));
      bool has_touched = false;
      for (int i = 1; i <= kSteps; ++i) has_touched |= proxy->step({.p_SD = at(i)}).contact;
      ASSERT_TRUE(has_touched);
      for (int i = kSteps - 1; i >= 0; --i) {
        const MethodOutput felt = proxy->step({.p_SD = at(i)});
        if (start_m - 0.0005 * i > 1e-5) {
          ASSERT_FALSE(felt.contact) << "friction " << friction << ", " << p.transpose() << ", step " << i;
        }
      }
      ++taps;
    };
    for (const double start_m : {0.002, 0.00225}) {  // with a sample at the surface, and without one
      for (std::size_t t = 0; t < bumps.triangles.size(); t += 97) {
        const auto [a, b, c] = bumps.triangles[t];
        const Vec3& va = bumps.vertices[a];
        const Vec3& vb = bumps.vertices[b];
        const Vec3& vc = bumps.vertices[c];
        tap((va + vb + vc) / 3.0, (vb - va).cross(vc - va).normalized(), start_m);
        tap(0.5 * (va + vb), (normals[a] + normals[b]).normalized(), start_m);
        tap(va, normals[a], start_m);
      }
    }
  }
  EXPECT_GT(taps, 500);
}

// A sliding proxy goes on sliding where one follower hands it over to another: with a static coefficient far above the dynamic one, a proxy
// that forgot that it slides would stick, and the force would rise to four times as much.
constexpr double kStaticCone = 0.8;
constexpr double kDynamicCone = 0.2;
constexpr double kFinnedSide = 0.1;
constexpr int kFinnedCells = 20;

// A sheet in the plane z = 0, bent up by `bend` radians on either side of y = 0. With `has_fins`, a triangle below the sheet hangs on every
// edge along y at x within -5 to 5 mm: faces that have three triangles at an edge are not walkable.
TriangleMesh make_finned_sheet(double bend, bool has_fins) {
  TriangleMesh sheet = make_plane_grid(kFinnedSide, kFinnedCells);
  for (Vec3& v : sheet.vertices) v = Vec3(v.x(), v.y() * std::cos(bend), std::abs(v.y()) * std::sin(bend));
  if (!has_fins) return sheet;
  const auto at = [](int i, int j) { return static_cast<std::uint32_t>(j * (kFinnedCells + 1) + i); };
  for (int i = 9; i <= 11; ++i) {
    for (int j = 0; j < kFinnedCells; ++j) {
      const Vec3 below = 0.5 * (sheet.vertices[at(i, j)] + sheet.vertices[at(i, j + 1)]) - Vec3(0, 0, 0.02);
      sheet.vertices.push_back(below);
      sheet.triangles.push_back({at(i, j), at(i, j + 1), static_cast<std::uint32_t>(sheet.vertices.size() - 1)});
    }
  }
  return sheet;
}

struct FinnedSlide {
  double least_ratio = 1e9;  // tangential over normal force, once it slides
  double most_ratio = 0.0;
  std::uint64_t walkable_steps = 0;
  std::uint64_t unwalkable_steps = 0;
};

// The device moves along x, 1 mm below z = 0, at the distance y from the middle of the sheet.
FinnedSlide slide_over_fins(const TriangleMesh& sheet, double y) {
  Material rough;
  rough.friction_static = kStaticCone;
  rough.friction_dynamic = kDynamicCone;
  auto made = ProxyMethod::make(MethodSettings(), scene_of(sheet, rough));
  EXPECT_TRUE(made);
  auto& proxy = static_cast<ProxyMethod&>(**made);
  const auto device = [&](double x, double z) { return Vec3(x, y, z); };
  proxy.reset(device(-0.04, 0.002));
  for (int i = 0; i <= 30; ++i) proxy.step({.p_SD = device(-0.04, 0.002 - 0.0001 * i)});
  // One contact offset, in the pull or in the depth of 1 mm.
  const double tolerance = 0x1p-30 * proxy.geometry().unit_m() / 0.001 * (1.0 + kStaticCone);
  FinnedSlide slide;
  for (int i = 0; i <= 800; ++i) {
    const double x = -0.04 + 0.0001 * i;
    const MethodOutput felt = proxy.step({.p_SD = device(x, -0.001)});
    EXPECT_TRUE(felt.contact) << "at x = " << x;
    const double ratio = std::abs(felt.force_n.x()) / std::hypot(felt.force_n.y(), felt.force_n.z());
    EXPECT_LE(ratio, (proxy.is_sliding() ? kDynamicCone : kStaticCone) + tolerance) << "at x = " << x;
    if (x < -0.03) continue;
    slide.least_ratio = std::min(slide.least_ratio, ratio);
    slide.most_ratio = std::max(slide.most_ratio, ratio);
    (std::abs(x) < 0.005 ? slide.unwalkable_steps : slide.walkable_steps) += 1;
  }
  return slide;
}

TEST(ProxySlide, GoesOnSlidingOverTrianglesThatAreNotWalkable) {
  for (const bool has_fins : {false, true}) {
    const FinnedSlide slide = slide_over_fins(make_finned_sheet(0.0, has_fins), 0.0013);
    EXPECT_NEAR(slide.least_ratio, kDynamicCone, 0.02 * kDynamicCone) << has_fins;
    EXPECT_NEAR(slide.most_ratio, kDynamicCone, 0.02 * kDynamicCone) << has_fins;
    EXPECT_GT(slide.unwalkable_steps, 90U);
  }
}

TEST(ProxySlide, GoesOnSlidingAlongAConcaveEdge) {
  for (const bool has_fins : {false, true}) {
    const FinnedSlide slide = slide_over_fins(make_finned_sheet(0.5, has_fins), 0.0);
    EXPECT_NEAR(slide.least_ratio, kDynamicCone, 0.02 * kDynamicCone) << has_fins;
    EXPECT_NEAR(slide.most_ratio, kDynamicCone, 0.02 * kDynamicCone) << has_fins;
  }
}

}  // namespace
}  // namespace hapton
