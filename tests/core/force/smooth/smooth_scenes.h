#pragma once

// Scenes and motions for the tests of method smooth.
#include <gtest/gtest.h>
#include <atomic>
#include <cmath>
#include <deque>
#include <functional>
#include <memory>
#include <numbers>
#include <random>
#include <thread>
#include <vector>
#include "core/force/smooth/smooth_method.h"
#include "core/geometry/mesh_shapes.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/made_meshes.h"
#include "tests/support/made_scene.h"
#include "tests/support/obj_mesh.h"

namespace hapton {

// The VCP is a billionth of the scene's size off the surface. These are the tolerances of otherwise exact results, in newtons and metres.
constexpr double kOffsetForce = 1e-6;
constexpr double kContactOffset = 1e-9;

inline std::unique_ptr<SmoothMethod> make_smooth(const TouchScene& scene, const MethodSettings& settings = {}) {
  auto method = SmoothMethod::make(settings, scene);
  EXPECT_TRUE(method) << (method ? "" : method.error().what);
  return method ? std::unique_ptr<SmoothMethod>(static_cast<SmoothMethod*>(method->release())) : nullptr;
}

inline MethodSettings with_size(std::uint32_t set_size, double layer = 0.0) {
  return {.set_size = static_cast<int>(set_size), .smooth_layer = layer};
}

inline double angle_between(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

// A hand that wanders over and into a mesh: towards a random point on it, about that point, out again. Some steps are tiny, some long.
inline std::vector<Vec3> wandering_path(const TriangleMesh& mesh, std::uint64_t seed, int steps) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto direction = [&] { return Vec3(unit(random), unit(random), unit(random)); };
  Vec3 low = mesh.vertices[0];
  Vec3 high = low;
  for (const Vec3& v : mesh.vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  const double size = (high - low).norm();
  std::vector<Vec3> path = {high + 0.1 * (high - low)};
  Vec3 goal = path[0];
  for (int i = 1; i < steps; ++i) {
    if (i % 150 == 1) goal = mesh.corner(random() % mesh.triangles.size(), 0) + 0.02 * size * direction();
    if (i % 600 == 500) goal = high + 0.1 * size * direction();
    Vec3 step = 0.05 * (goal - path.back()) + 2e-4 * size * direction();
    if (i % 37 == 0) step *= 1e-6;
    path.push_back(path.back() + step);
  }
  return path;
}

inline std::unique_ptr<ForceMethod> make_with_crease(const TouchScene& scene, double crease_deg, double simplify_m) {
  auto method = SmoothMethod::make({.crease_deg = crease_deg, .simplify_m = simplify_m}, scene);
  EXPECT_TRUE(method) << (method ? "" : method.error().what);
  return method ? std::move(*method) : nullptr;
}

// Winding number of a closed surface about p: 1 inside, 0 outside.
inline double winding_number(const TriangleMesh& mesh, const Vec3& p) {
  double sum = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 a = mesh.corner(t, 0) - p;
    const Vec3 b = mesh.corner(t, 1) - p;
    const Vec3 c = mesh.corner(t, 2) - p;
    sum += std::atan2(a.dot(b.cross(c)), a.norm() * b.norm() * c.norm() + a.dot(b) * c.norm() + b.dot(c) * a.norm() + c.dot(a) * b.norm());
  }
  return sum / (2.0 * std::numbers::pi);
}

}  // namespace hapton
