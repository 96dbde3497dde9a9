#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <random>

#include "core/geometry/triangle_mesh.h"

// Meshes made by formula, for tests that need no file.
namespace hapton::made {

// Axis-aligned box, outward normals, 12 triangles.
inline TriangleMesh box(const Vec3& low, const Vec3& high) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.emplace_back((i & 1) != 0 ? high[0] : low[0], (i & 2) != 0 ? high[1] : low[1], (i & 4) != 0 ? high[2] : low[2]);
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

// Square of side 2 * half in the plane z = height, normal +z, cut into n x n squares of two triangles.
inline TriangleMesh sheet(double half, double height, int n) {
  TriangleMesh mesh;
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      mesh.vertices.emplace_back(half * (2.0 * i / n - 1.0), half * (2.0 * j / n - 1.0), height);
    }
  }
  const auto at = [n](int i, int j) { return static_cast<std::uint32_t>(j * (n + 1) + i); };
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return mesh;
}

// Closed sphere of latitude bands, outward normals; bumps > 0 adds waves of unequal lengths, up to bumps * radius high.
inline TriangleMesh sphere(double radius, int bands, double bumps = 0.0) {
  TriangleMesh mesh;
  const int around = 2 * bands;
  const auto point = [&](double polar, double azimuth) {
    const double r = radius * (1.0 + bumps * std::sin(7.0 * polar) * std::sin(5.0 * azimuth + 1.0));
    return Vec3(r * std::sin(polar) * std::cos(azimuth), r * std::sin(polar) * std::sin(azimuth), r * std::cos(polar));
  };
  mesh.vertices.push_back(point(0.0, 0.0));
  for (int b = 1; b < bands; ++b) {
    for (int a = 0; a < around; ++a) {
      mesh.vertices.push_back(point(std::numbers::pi * b / bands, 2.0 * std::numbers::pi * a / around));
    }
  }
  mesh.vertices.push_back(point(std::numbers::pi, 0.0));
  const auto last = static_cast<std::uint32_t>(mesh.vertices.size() - 1);
  const auto at = [around](int b, int a) { return static_cast<std::uint32_t>(1 + (b - 1) * around + a % around); };
  for (int a = 0; a < around; ++a) {
    mesh.triangles.push_back({0, at(1, a), at(1, a + 1)});
    for (int b = 1; b < bands - 1; ++b) {
      mesh.triangles.push_back({at(b, a), at(b + 1, a), at(b + 1, a + 1)});
      mesh.triangles.push_back({at(b, a), at(b + 1, a + 1), at(b, a + 1)});
    }
    mesh.triangles.push_back({at(bands - 1, a), last, at(bands - 1, a + 1)});
  }
  return mesh;
}

// Loose triangles, some of them needles, some degenerate; the first corner of each lies in a cube of side 2 * half, the others near it.
inline TriangleMesh soup(std::uint64_t seed, int count, double half, double size) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto vector = [&] { return Vec3(unit(random), unit(random), unit(random)); };
  TriangleMesh mesh;
  for (int t = 0; t < count; ++t) {
    const Vec3 a = half * vector();
    const Vec3 b = a + size * vector();
    Vec3 c = a + size * vector();
    if (t % 10 == 1) {
      c = a + 0.6 * (b - a) + 1e-6 * size * vector();  // needle
    } else if (t % 50 == 2) {
      c = a;  // no area
    }
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {a, b, c});
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

inline std::shared_ptr<const TriangleMesh> shared(TriangleMesh mesh) { return std::make_shared<const TriangleMesh>(std::move(mesh)); }

}  // namespace hapton::made
