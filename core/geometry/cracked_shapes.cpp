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
Vec3 draw_move(Random& random, double max_move) {
  std::uniform_real_distribution<double> symmetric(-1.0, 1.0);
  for (;;) {
    const Vec3 p(symmetric(random), symmetric(random), symmetric(random));
    if (p.squaredNorm() <= 1.0) return max_move * p;
  }
}

// Each triangle gets its own vertices.
TriangleMesh separate_triangles(const TriangleMesh& mesh) {
  TriangleMesh loose;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto first = static_cast<std::uint32_t>(loose.vertices.size());
    for (int k = 0; k < 3; ++k) loose.vertices.push_back(mesh.corner(i, k));
    loose.triangles.push_back({first, first + 1, first + 2});
  }
  return loose;
}

// Adds the strip between two rows of vertices, each numbered from left to right as seen from outside. low, high: the first vertex of the
// lower and of the upper row. Each triangle advances in the row whose next edge has its middle farther to the left.
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

// A sphere with waves: three round each parallel, highest at 45 degrees of latitude, and of no height at the equator and at the poles.
struct WavySphere {
  double radius_m = 0.0;
  double relative_height = 0.0;
  Vec3 at(double polar_rad, double azimuth_rad) const {
    const double wave = std::sin(2.0 * polar_rad) * std::sin(3.0 * azimuth_rad + 1.0);  // 1 rad: no wave begins at a coordinate plane
    const double r = radius_m * (1.0 + relative_height * wave);
    return {r * std::sin(polar_rad) * std::cos(azimuth_rad), r * std::sin(polar_rad) * std::sin(azimuth_rad), r * std::cos(polar_rad)};
  }
};

// A patch of the sphere between two meridians, from the equator to a pole.
struct SpherePatch {
  double from_rad = 0.0;  // azimuth
  double to_rad = 0.0;
  bool is_above = true;  // above the equator
  int equator_cells = 0;
};

// Adds rings of vertices from the equator to the pole, each with about half as many vertices as the ring before. Vertices on the patch's
// seams are moved by up to max_move at random.
void add_patch(TriangleMesh& mesh, const WavySphere& sphere, const SpherePatch& patch, double max_move, Random& random) {
  constexpr int kRings = 12;  // halves a few thousand cells along the equator to one before the pole
  std::vector<std::uint32_t> first;
  std::vector<int> count;
  for (int ring = 0; ring <= kRings; ++ring) {
    const bool is_pole = ring == kRings;
    first.push_back(static_cast<std::uint32_t>(mesh.vertices.size()));
    count.push_back(is_pole ? 1 : std::max(2, (patch.equator_cells >> ring) + 1));
    const double polar = 0.5 * std::numbers::pi * (1.0 - static_cast<double>(ring) / kRings);
    for (int i = 0; i < count[ring]; ++i) {
      const double share = is_pole ? 0.0 : static_cast<double>(i) / (count[ring] - 1);
      const double azimuth = patch.from_rad + share * (patch.to_rad - patch.from_rad);
      Vec3 p = sphere.at(patch.is_above ? polar : std::numbers::pi - polar, azimuth);
      if (is_pole) p = sphere.at(patch.is_above ? 0.0 : std::numbers::pi, 0.0);  // the same point for all patches, to the bit
      const bool is_on_seam = ring == 0 || is_pole || i == 0 || i + 1 == count[ring];
      mesh.vertices.push_back(is_on_seam ? Vec3(p + draw_move(random, max_move)) : p);
    }
  }
  for (int ring = 0; ring < kRings; ++ring) {
    const std::size_t start = mesh.triangles.size();
    add_strip(mesh, first[ring], count[ring], first[ring + 1], count[ring + 1]);
    if (patch.is_above) continue;
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
  constexpr double kRim = 0.5 - 1e-9;  // on the unit square: less than half its side by more than rounding, and by less than a cell
  Random random(seed);
  TriangleMesh box;
  for (int face = 0; face < 6; ++face) {
    const int cells = 3 + 2 * face;  // no two faces have the same
    TriangleMesh sheet = make_plane_grid(1.0, cells);
    const int axis = face / 2;
    const double side = face % 2 == 0 ? 1.0 : -1.0;
    for (Vec3& vertex : sheet.vertices) {
      const bool at_rim = vertex.cwiseAbs().maxCoeff() > kRim;
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
  struct Half {
    int patches = 0;
    bool is_above = true;
    double first_meridian_rad = 0.0;
  };
  constexpr Half kHalves[] = {{3, true, 0.1}, {4, false, 0.35}};  // no meridian seam of one half continues one of the other half
  constexpr double kMoreCells = 0.13;                             // each patch of a half has so many more cells, as a share of the first's
  // Makes the chords of a wavy sphere shorter than the gaps require, as does 1 + relative_height in `length` below. The recorded results of
  // `hapton stress` are for these meshes.
  constexpr double kShorterForWaves = 12.0;
  Random random(seed);
  // The equator is a circle of the sphere's radius R, since the waves have no height there. A chord of length L has the sagitta
  // L^2 / (8 R), and this may be a quarter of the width. With the moves of the vertices at its ends and of the vertex beside it, no gap is
  // wider than three quarters of the width.
  const double chord = std::sqrt(2.0 * width * radius_m / (1.0 + kShorterForWaves * relative_height));
  TriangleMesh sphere;
  for (const Half& half : kHalves) {
    const double angle = 2.0 * std::numbers::pi / half.patches;
    for (int i = 0; i < half.patches; ++i) {
      const double from = half.first_meridian_rad + i * angle;
      const double length = angle * radius_m * (1.0 + relative_height);
      const int cells = static_cast<int>(std::ceil(length / chord * (1.0 + kMoreCells * i)));
      add_patch(sphere, {radius_m, relative_height}, {from, from + angle, half.is_above, cells}, 0.25 * width, random);
    }
  }
  return sphere;
}

}  // namespace hapton
