#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <iostream>
#include <numbers>
#include <random>
#include <set>
#include <vector>

#include "core/force/proxy/surface_point.h"

namespace hapton {

// A mesh in its local frame, and a SurfacePoint that can be put on its surface.
struct SurfaceStage {
  explicit SurfaceStage(const TriangleMesh& mesh, bool two_sided = true) : geometry({&mesh}), materials(1), point(geometry, materials) {
    materials[0].two_sided = two_sided;
  }

  Vec3 local(double x, double y, double z) const { return geometry.to_local(Vec3(x, y, z)); }
  std::uint32_t count() const { return static_cast<std::uint32_t>(geometry.triangle_count()); }
  Vec3 middle(std::uint32_t t) const { return (geometry.corner(t, 0) + geometry.corner(t, 1) + geometry.corner(t, 2)) / 3.0; }
  Vec3 on_edge(std::uint32_t t, int k, double along) const {
    return (1.0 - along) * geometry.corner(t, k) + along * geometry.corner(t, (k + 1) % 3);
  }
  // TouchGeometry rounds corners to a grid, so they are compared up to that rounding.
  bool is_corner(std::uint32_t t, int k, const Vec3& p) const { return (geometry.corner(t, k) - p).norm() < 0x1p-49; }
  // All triangles that have a corner at `vertex`.
  std::set<std::uint32_t> round(const Vec3& vertex) const {
    std::set<std::uint32_t> found;
    for (std::uint32_t t = 0; t < count(); ++t) {
      for (int k = 0; k < 3; ++k) {
        if (is_corner(t, k, vertex)) found.insert(t);
      }
    }
    return found;
  }
  // Puts the point on that vertex, on the front or the back of a triangle there. False: there is none.
  bool stand_at_vertex(const Vec3& vertex, bool back = false) {
    for (std::uint32_t t = 0; t < count(); ++t) {
      for (int k = 0; k < 3; ++k) {
        if (is_corner(t, k, vertex)) return point.land(t, back, middle(t)) && point.reach_vertex(k);
      }
    }
    return false;
  }

  TouchGeometry geometry;
  std::vector<Material> materials;
  SurfacePoint point;
};

inline std::mt19937_64 make_random(std::uint64_t seed) {
  std::cout << "seed " << seed << "\n";
  return std::mt19937_64(seed);
}

inline Vec3 random_vector(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const double x = normal(random), y = normal(random), z = normal(random);
  return {x, y, z};
}

inline void expect_near(const Vec3& p, const Vec3& q, double within = 1e-13) {
  EXPECT_LT((p - q).norm(), within) << p.transpose() << " and " << q.transpose();
}

// A fan of triangles around the origin, front side up; its rim points have z = height * cos(waves * angle).
inline TriangleMesh make_saddle(int waves, double height, int corners) {
  TriangleMesh mesh;
  mesh.vertices.emplace_back(0, 0, 0);
  const auto n = static_cast<std::uint32_t>(corners);
  for (std::uint32_t i = 0; i < n; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / n + 0.1;
    mesh.vertices.emplace_back(std::cos(angle), std::sin(angle), height * std::cos(waves * angle));
    mesh.triangles.push_back({0, i + 1, (i + 1) % n + 1});
  }
  return mesh;
}

}  // namespace hapton
