#pragma once

// Scenes and expectations for the tests of method reference.
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include "core/force/evaluation/stress_body.h"
#include "core/force/reference/reference_method.h"
#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_shapes.h"
#include "core/geometry/touch_trajectory.h"
#include "tests/support/made_scene.h"

namespace hapton {

constexpr double kReferenceStiffness = 1000.0;

inline std::unique_ptr<ReferenceMethod> reference_over(TriangleMesh mesh, double probe_radius_m = 0.0, Material material = {},
                                                       bool prefilter = true, int substeps = 8) {
  MethodSettings settings;
  settings.name = "reference";
  settings.probe_radius_m = probe_radius_m;
  settings.reference_substeps = substeps;
  auto made = ReferenceMethod::make_reference(settings, scene_of(std::move(mesh), material), prefilter);
  EXPECT_TRUE(made.has_value());
  return std::move(*made);
}

// A random walk of the device over a surface: seeded, about 0.1 mm a step. visit(position, step) is called in each step.
template <class Visit>
inline void random_walk(std::uint64_t seed, int steps, const std::function<Vec3(double, double)>& surface, Visit visit) {
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  double u = 0.3, v = 0.7;
  for (int i = 0; i < steps; ++i) {
    u += 0.002 * normal(random);
    v += 0.002 * normal(random);
    visit(surface(u, v), i);
  }
}

// ---- Curved shapes: the mesh lies inside the shape by at most the sagitta, and its normals differ by at most the facet's half angle. ----

struct CurvedShape {
  const char* name;
  TriangleMesh mesh;
  std::function<Vec3(double, double)> at_depth_1mm;
  std::function<Vec3(const Vec3&)> nearest;  // on the analytic surface
  double sagitta_m;                          // the farthest the mesh is from the surface
  double tilt_rad;                           // the farthest a face's normal is from the surface's
};

inline void expect_close_to_analytic(const CurvedShape& shape, double probe) {
  auto method = reference_over(shape.mesh, probe);
  const Vec3 first = shape.at_depth_1mm(0.3, 0.7);
  const Vec3 outwards = (shape.nearest(first) - first).normalized();
  method->reset(first + 0.01 * outwards);
  method->step({.p_SD = first});
  int contacts = 0;
  random_walk(9, 1500, shape.at_depth_1mm, [&](const Vec3& device, int i) {
    const MethodOutput felt = method->step({.p_SD = device});
    const Vec3 depth = shape.nearest(device) - device;
    const Vec3 expected = kReferenceStiffness * (depth + probe * depth.normalized());
    // Along the depth, the closest point of the mesh is within the sagitta of that of the shape. Sideways, it is on a face that is tilted
    // by at most tilt_rad, so the force is turned by at most that angle.
    const double strength = expected.norm();
    ASSERT_TRUE(felt.contact) << shape.name << ' ' << i;
    ASSERT_NEAR(felt.force_n.norm(), strength,
                kReferenceStiffness * shape.sagitta_m + strength * 0.5 * shape.tilt_rad * shape.tilt_rad + 1e-6)
        << shape.name << ' ' << i;
    ASSERT_LT((felt.force_n - expected).norm(), kReferenceStiffness * shape.sagitta_m + strength * 1.05 * shape.tilt_rad + 1e-6)
        << shape.name << ' ' << i;
    ++contacts;
  });
  EXPECT_EQ(contacts, 1500);
  EXPECT_EQ(method->counters().proxy.unconverged, 0u) << shape.name;
}

// The longest edge e of a mesh inscribed in radius r. A face has a circumradius of at most e / sqrt(3) if it is nearly equilateral, and of
// at most e / 2 if it is right-angled; e / sqrt(3) bounds both.
inline double longest_edge(const TriangleMesh& mesh) {
  double longest = 0.0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (int k = 0; k < 3; ++k) longest = std::max(longest, (mesh.corner(i, k) - mesh.corner(i, (k + 1) % 3)).norm());
  }
  return longest;
}

inline CurvedShape make_sphere_case() {
  const double r = 0.05;
  TriangleMesh mesh = make_icosphere(r, 6);
  const double reach = longest_edge(mesh) / std::sqrt(3.0);
  return {"sphere",
          std::move(mesh),
          [=](double u, double v) { return Vec3((r - 0.001) * Vec3(std::cos(u) * std::cos(v), std::sin(u) * std::cos(v), std::sin(v))); },
          [=](const Vec3& p) { return Vec3(r * p.normalized()); },
          r - std::sqrt(r * r - reach * reach),
          std::asin(reach / r)};
}

inline CurvedShape make_cylinder_case() {
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
          std::numbers::pi / sides};
}

inline CurvedShape make_torus_case() {
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
          1.5 * (step_tube + step_ring)};
}

// ---- The limit of ever finer sub-steps. ----

inline std::unique_ptr<ReferenceMethod> limit_over(TriangleMesh mesh, int substeps, int limit, Material material = {}) {
  MethodSettings settings;
  settings.reference_substeps = substeps;
  settings.reference_substep_limit = limit;
  auto made = ReferenceMethod::make_reference(settings, scene_of(std::move(mesh), material));
  EXPECT_TRUE(made.has_value());
  return std::move(*made);
}

inline TriangleMesh box_between(const Vec3& low, const Vec3& high) {
  return scaled_and_moved(make_box(high - low), 1.0, 0.5 * (low + high));
}

// A block with its top in y = 0 and its right side in x = 0; a shelf beside it, below the top, that leaves a gap.
inline TriangleMesh block_and_shelf(double gap) {
  return joined(box_between({-0.1, -0.1, -0.05}, {0.0, 0.0, 0.05}), box_between({gap, -0.020, -0.05}, {0.03, -0.016, 0.05}));
}

constexpr double kJump = 0.02;   // motion of the device in one step, along x
constexpr double kDepth = 0.04;  // depth of the device below the top of the block; also below the shelf
// With 8 sub-steps the proxy is released so late that at the lower edge of the shelf it is (0.625 - 0.53) / 2 of the jump beside the block:
// past the gap. With 16 it is (0.5625 - 0.53) / 2.
constexpr double kGap = 0.025 * kJump;

// The device passes the side of the block at the share `at` of its step. At that time the proxy, held above it on the edge, is released,
// falls straight to the device through the gap, and is free from then on. If the sub-steps are too long, it falls onto the shelf.
inline ReferenceStep jump(ReferenceMethod& method, double at, MethodOutput& felt) {
  method.reset(Vec3(-at * kJump, 0.001, 0.0));
  method.step({.p_SD = Vec3(-at * kJump, -kDepth, 0.0)});
  felt = method.step({.p_SD = Vec3((1.0 - at) * kJump, -kDepth, 0.0)});
  return method.last_step();
}

}  // namespace hapton
