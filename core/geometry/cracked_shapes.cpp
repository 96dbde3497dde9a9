#include "core/geometry/cracked_shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

using Random = std::mt19937_64;

// A random displacement, uniform in a ball.
Vec3 draw_move(Random& random, double radius) {
  std::uniform_real_distribution<double> symmetric(-1.0, 1.0);
  for (;;) {
    const Vec3 p(symmetric(random), symmetric(random), symmetric(random));
    if (p.squaredNorm() <= 1.0) return radius * p;
  }
}

TriangleMesh separate_triangles(const TriangleMesh& mesh) {
  TriangleMesh loose;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto first = static_cast<std::uint32_t>(loose.vertices.size());
    for (int k = 0; k < 3; ++k) loose.vertices.push_back(mesh.corner(i, k));
    loose.triangles.push_back({first, first + 1, first + 2});
  }
  return loose;
}

// Adds the strip between two rows of vertices, each numbered from left to right. Seen from outside, `low` is the lower row.
void add_strip(TriangleMesh& mesh, std::uint32_t low, int low_count, std::uint32_t high, int high_count) {
  int i = 0;
  int j = 0;
  while (i + 1 < low_count || j + 1 < high_count) {
    const auto a = low + static_cast<std::uint32_t>(i);
    const auto b = high + static_cast<std::uint32_t>(j);
    const bool advances_low = j + 1 == high_count || (i + 1 < low_count && (2 * i + 1) * (high_count - 1) <= (2 * j + 1) * (low_count - 1));
    if (advances_low) {
      mesh.triangles.push_back({a, a + 1, b});
      ++i;
    } else {
      mesh.triangles.push_back({a, b + 1, b});
      ++j;
    }
  }
}

struct Waves {
  double radius_m = 0.0;
  double relative_height = 0.0;
  Vec3 at(double polar, double azimuth) const {
    const double r = radius_m * (1.0 + relative_height * std::sin(2.0 * polar) * std::sin(3.0 * azimuth + 1.0));
    return {r * std::sin(polar) * std::cos(azimuth), r * std::sin(polar) * std::sin(azimuth), r * std::cos(polar)};
  }
};

struct Sector {
  double from = 0.0;  // azimuth
  double to = 0.0;
  double side = 1.0;  // 1: above the equator; -1: below
  int cells_along_equator = 0;
};

// Adds rings of vertices from the equator to the pole, each with about half as many vertices as the ring before.
void add_sector(TriangleMesh& mesh, const Waves& waves, const Sector& sector, int rings, double most_move, Random& random) {
  std::vector<std::uint32_t> first;
  std::vector<int> count;
  for (int ring = 0; ring <= rings; ++ring) {
    first.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
    count.push_back(ring == rings ? 1 : std::max(2, (sector.cells_along_equator >> ring) + 1));
    const double polar = 0.5 * std::numbers::pi * (1.0 - static_cast<double>(ring) / rings);
    for (int i = 0; i < count[ring]; ++i) {
      const double share = count[ring] == 1 ? 0.0 : static_cast<double>(i) / (count[ring] - 1);
      const double azimuth = sector.from + share * (sector.to - sector.from);
      Vec3 p = waves.at(sector.side > 0.0 ? polar : std::numbers::pi - polar, azimuth);
      if (ring == rings) p = waves.at(sector.side > 0.0 ? 0.0 : std::numbers::pi, 0.0);
      const bool at_seam = ring == 0 || ring == rings || i == 0 || i + 1 == count[ring];
      mesh.vertices.push_back(at_seam ? Vec3(p + draw_move(random, most_move)) : p);
    }
  }
  for (int ring = 0; ring < rings; ++ring) {
    const std::size_t start = mesh.triangles.size();
    add_strip(mesh, first[ring], count[ring], first[ring + 1], count[ring + 1]);
    if (sector.side > 0.0) continue;
    for (std::size_t t = start; t < mesh.triangles.size(); ++t) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
  }
}

}  // namespace

TriangleMesh make_torn(const TriangleMesh& mesh, double width) {
  TriangleMesh torn = separate_triangles(mesh);
  for (const Triangle& t : torn.triangles) {
    const Vec3 middle = (torn.vertices[t[0]] + torn.vertices[t[1]] + torn.vertices[t[2]]) / 3.0;
    for (const std::uint32_t v : t) torn.vertices[v] += 0.5 * width * (middle - torn.vertices[v]).normalized();
  }
  return torn;
}

TriangleMesh make_shaken(const TriangleMesh& mesh, double width, std::uint64_t seed) {
  Random random(seed);
  TriangleMesh shaken = separate_triangles(mesh);
  for (Vec3& vertex : shaken.vertices) vertex += draw_move(random, 0.5 * width);
  return shaken;
}

TriangleMesh make_patched_box(const Vec3& size_m, double width, std::uint64_t seed) {
  Random random(seed);
  TriangleMesh box;
  for (int face = 0; face < 6; ++face) {
    const int cells = 3 + 2 * face;
    TriangleMesh sheet = make_plane_grid(1.0, cells);
    const int axis = face / 2;
    const double side = face % 2 == 0 ? 1.0 : -1.0;
    for (Vec3& vertex : sheet.vertices) {
      const bool at_rim = vertex.cwiseAbs().maxCoeff() > 0.5 - 1e-9;
      Vec3 p;
      p[axis] = 0.5 * side;
      p[(axis + 1) % 3] = vertex.x();
      p[(axis + 2) % 3] = side * vertex.y();
      vertex = p.cwiseProduct(size_m);
      if (at_rim) vertex += draw_move(random, 0.5 * width);
    }
    box = joined(box, sheet);
  }
  return box;
}

TriangleMesh make_patched_sphere(double radius_m, double relative_height, double width, std::uint64_t seed) {
  constexpr int kRings = 12;
  constexpr double kCurvatureAllowance = 12.0;  // allowance for curvature: this times the relative height is added to that of a sphere
  Random random(seed);
  const Waves waves{radius_m, relative_height};
  // A chord of length L under a curvature c has the sagitta L^2 c / 8, which should be a quarter of the width.
  const double chord = std::sqrt(2.0 * width * radius_m / (1.0 + kCurvatureAllowance * relative_height));
  TriangleMesh sphere;
  for (const auto& [sectors, side, turn] : {std::array{3.0, 1.0, 0.1}, std::array{4.0, -1.0, 0.35}}) {
    for (int i = 0; i < static_cast<int>(sectors); ++i) {
      const double angle = 2.0 * std::numbers::pi / sectors;
      const double from = turn + i * angle;
      const double length = angle * radius_m * (1.0 + relative_height);
      const int along = static_cast<int>(std::ceil(length / chord * (1.0 + 0.13 * i)));
      add_sector(sphere, waves, {from, from + angle, side, along}, kRings, 0.25 * width, random);
    }
  }
  return sphere;
}

}  // namespace hapton
