#include "core/force/evaluation/stress_body.h"

#include <array>
#include <cmath>
#include <random>
#include <utility>

#include "core/force/evaluation/stress_parts.h"
#include "core/geometry/cracked_shapes.h"
#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_shapes.h"
#include "core/geometry/seal_cracks.h"

namespace hapton {
namespace {

constexpr double kExtent = 0.1;

using Random = std::mt19937_64;

Vec3 draw_vector(Random& random) {
  std::uniform_real_distribution<double> symmetric(-1.0, 1.0);
  return {symmetric(random), symmetric(random), symmetric(random)};
}

StressBody clean(TriangleMesh mesh) { return {.name = {}, .touched = mesh, .solid = mesh}; }

StressBody dirty(TriangleMesh touched, TriangleMesh solid) {
  return {.name = {}, .touched = std::move(touched), .solid = std::move(solid)};
}

// Some triangles get a vertex inside, as near to a corner as 1e-7 of their size: two of three parts are needles. The mesh stays closed.
TriangleMesh with_needles(TriangleMesh mesh, std::uint64_t seed) {
  Random random(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  std::vector<Triangle> added;
  for (Triangle& triangle : mesh.triangles) {
    if (uniform(random) < 0.5) continue;
    // A new vertex near corner 0, strictly inside: three triangles instead of one, two of them needles.
    const double share = std::pow(10.0, -1.0 - 6.0 * uniform(random));
    const Vec3 &a = mesh.vertices[triangle[0]], &b = mesh.vertices[triangle[1]], &c = mesh.vertices[triangle[2]];
    const Vec3 inner = a + share * (0.6 * (b - a) + 0.3 * (c - a));
    const auto at = static_cast<std::uint32_t>(mesh.vertices.size());
    const auto [i, j, k] = triangle;
    mesh.vertices.push_back(inner);
    added.push_back({j, k, at});
    added.push_back({k, i, at});
    triangle = {i, j, at};
  }
  mesh.triangles.insert(mesh.triangles.end(), added.begin(), added.end());
  return mesh;
}

// Adds a degenerate triangle beside each triangle: one with a repeated corner, three corners in a line, or a single point.
TriangleMesh with_zero_area(TriangleMesh mesh) {
  const std::size_t n = mesh.triangles.size();
  for (std::size_t i = 0; i < n; ++i) {
    const auto [a, b, c] = mesh.triangles[i];
    switch (i % 4) {
      case 0:
        mesh.triangles.push_back({a, a, b});
        break;
      case 1:
        mesh.triangles.push_back({c, c, c});
        break;
      case 2: {
        mesh.vertices.push_back(0.5 * (mesh.vertices[a] + mesh.vertices[b]));
        mesh.triangles.push_back({a, b, static_cast<std::uint32_t>(mesh.vertices.size() - 1)});
        break;
      }
      default:
        mesh.triangles.push_back({b, c, b});
    }
  }
  return mesh;
}

TriangleMesh doubled(const TriangleMesh& mesh, bool turned) {
  TriangleMesh both = mesh;
  for (const Triangle& triangle : mesh.triangles)
    both.triangles.push_back(turned ? Triangle{triangle[0], triangle[2], triangle[1]} : triangle);
  return both;
}

// Each triangle has its own vertices, moved towards its middle by a share of the extent.
TriangleMesh cracked(const TriangleMesh& mesh, double share) {
  TriangleMesh torn;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Vec3 middle = (mesh.corner(i, 0) + mesh.corner(i, 1) + mesh.corner(i, 2)) / 3.0;
    const auto at = static_cast<std::uint32_t>(torn.vertices.size());
    for (int k = 0; k < 3; ++k) {
      const Vec3 to = middle - mesh.corner(i, k);
      torn.vertices.push_back(mesh.corner(i, k) + to * (share * kExtent / to.norm()));
    }
    torn.triangles.push_back({at, at + 1, at + 2});
  }
  return torn;
}

// Every second triangle is split at the middle of an edge that its neighbour keeps whole; the middle is moved by up to a share of the
// extent.
TriangleMesh with_t_junctions(const TriangleMesh& mesh, double share) {
  Random random(5);
  TriangleMesh split{.vertices = mesh.vertices, .triangles = {}};
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto [a, b, c] = mesh.triangles[i];
    if (i % 2 == 0) {
      split.triangles.push_back({a, b, c});
      continue;
    }
    const auto at = static_cast<std::uint32_t>(split.vertices.size());
    split.vertices.push_back(0.5 * (mesh.vertices[a] + mesh.vertices[b]) + share * kExtent * draw_vector(random) / std::sqrt(3.0));
    split.triangles.push_back({a, at, c});
    split.triangles.push_back({at, b, c});
  }
  return split;
}

TriangleMesh turned_at_random(TriangleMesh mesh) {
  Random random(6);
  for (Triangle& triangle : mesh.triangles) {
    if (random() % 2 == 0) std::swap(triangle[1], triangle[2]);
  }
  return mesh;
}

TriangleMesh askew(TriangleMesh mesh) {
  const Mat3 turn = (Eigen::AngleAxisd(0.7, Vec3::UnitX()) * Eigen::AngleAxisd(1.1, Vec3::UnitY()) * Eigen::AngleAxisd(0.3, Vec3::UnitZ()))
                        .toRotationMatrix();
  for (Vec3& vertex : mesh.vertices) vertex = turn * vertex;
  return mesh;
}

TriangleMesh ball() { return make_icosphere(0.5 * kExtent, 3); }
TriangleMesh bumps() { return make_bumpy_sphere(0.45 * kExtent, 0.25, 5000, 1); }

TriangleMesh tetrahedron() {
  TriangleMesh mesh;
  const double h = 0.5 * kExtent;
  mesh.vertices = {{h, h, h}, {-h, -h, h}, {-h, h, -h}, {h, -h, -h}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return mesh;
}

StressBody room_of(TriangleMesh shell, double probe_share) {
  return {.name = {}, .touched = flipped(shell), .solid = std::move(shell), .room = true, .probe_share = probe_share};
}

// A mesh with cracks and T-junctions, sealed as a mesh is when it is loaded for touch. The sealed mesh defines the solid.
StressBody sealed(TriangleMesh cracked) {
  SealReport report;
  return clean(seal_cracks(std::move(cracked), report));
}

// width_share: width of the widest gap, as a share of the extent. Cracks at every edge: a sphere, and a star with sharp spikes.
StressBody sealed_tears(double width_share) { return sealed(make_shaken(ball(), width_share * kExtent, 1)); }
StressBody sealed_star(double width_share) { return sealed(make_shaken(make_star(), 0.9 * width_share * kExtent, 2)); }
// Faces with different tessellations, flat: a box.
StressBody sealed_box(double width_share) { return sealed(make_patched_box(Vec3(1.0, 0.8, 0.6) * kExtent, width_share * kExtent, 3)); }
// Patches with different tessellations, curved: a sphere and a wavy one; the two sides of a seam follow different chords.
StressBody sealed_ball(double width_share) { return sealed(make_patched_sphere(0.5 * kExtent, 0.0, width_share * kExtent, 4)); }
StressBody sealed_waves(double width_share) { return sealed(make_patched_sphere(0.48 * kExtent, 0.1, 0.9 * width_share * kExtent, 5)); }

StressBody with_probe(StressBody body, double share) {
  body.probe_share = share;
  return body;
}

struct Entry {
  std::string_view name;
  StressBody (*make)();
};

constexpr std::array kBodies = {
    Entry{"sphere", [] { return clean(ball()); }},
    Entry{"box", [] { return clean(make_box(Vec3::Constant(kExtent), 3)); }},
    Entry{"turned-box", [] { return clean(askew(make_box(Vec3(0.6, 0.5, 0.4) * kExtent, 2))); }},
    Entry{"cylinder", [] { return clean(make_cylinder(0.3 * kExtent, kExtent, 48, 2)); }},
    Entry{"torus", [] { return clean(make_torus(0.35 * kExtent, 0.15 * kExtent, 48, 24)); }},
    Entry{"tetrahedron", [] { return clean(tetrahedron()); }},
    Entry{"bumpy", [] { return clean(bumps()); }},
    Entry{"star", [] { return clean(make_star()); }},
    Entry{"gutter", [] { return clean(make_gutter(kExtent, 0.3 * kExtent, 0.4, 6)); }},
    Entry{"knife-gutter", [] { return clean(askew(make_gutter(kExtent, 0.5 * kExtent, 0.01, 4))); }},
    Entry{"staircase", [] { return clean(make_staircase(kExtent, 8, 4)); }},
    Entry{"pit", [] { return clean(askew(make_pit(kExtent, 0.5 * kExtent))); }},
    Entry{"thin-wall", [] { return clean(make_thin_wall(kExtent, 0.01 * kExtent, 6)); }},
    Entry{"needles", [] { return clean(with_needles(ball(), 3)); }},
    Entry{"sliver-fan", [] { return clean(make_cylinder(0.5 * kExtent, 0.02 * kExtent, 3000, 1)); }},
    Entry{"zero-area", [] { return dirty(with_zero_area(ball()), ball()); }},
    Entry{"duplicates", [] { return dirty(doubled(ball(), false), ball()); }},
    Entry{"turned-duplicates", [] { return dirty(doubled(bumps(), true), bumps()); }},
    Entry{"inverted", [] { return dirty(flipped(bumps()), bumps()); }},
    Entry{"mixed-winding", [] { return dirty(turned_at_random(bumps()), bumps()); }},
    Entry{"hair-cracks", [] { return dirty(cracked(ball(), 1e-11), ball()); }},
    Entry{"hair-t-junctions", [] { return dirty(with_t_junctions(ball(), 1e-11), ball()); }},
    Entry{"sealed-tears", [] { return sealed_tears(0.9e-4); }},
    Entry{"sealed-tears-fine", [] { return sealed_tears(1e-5); }},
    Entry{"sealed-star", [] { return sealed_star(0.9e-4); }},
    Entry{"sealed-star-fine", [] { return sealed_star(1e-5); }},
    Entry{"sealed-ball", [] { return sealed_ball(0.9e-4); }},
    Entry{"sealed-ball-fine", [] { return sealed_ball(1e-5); }},
    Entry{"sealed-waves", [] { return sealed_waves(0.9e-4); }},
    Entry{"sealed-waves-fine", [] { return sealed_waves(1e-5); }},
    Entry{"sealed-box", [] { return sealed_box(0.9e-4); }},
    Entry{"sealed-box-fine", [] { return sealed_box(1e-5); }},
    Entry{"room", [] { return room_of(make_box(Vec3(1.0, 0.8, 0.6) * kExtent, 3), 0.0); }},
    Entry{"turned-room", [] { return room_of(askew(make_box(Vec3(0.6, 0.5, 0.4) * kExtent, 2)), 0.0); }},
    Entry{"round-room", [] { return room_of(ball(), 0.0); }},
    Entry{"slotted-part", [] { return clean(make_slotted_part(1, 0.0)); }},
    Entry{"bent-part", [] { return clean(make_slotted_part(2, 0.6 * kExtent)); }},
    Entry{"open-front", [] { return dirty(make_open_front(2), {}); }},
    Entry{"touching-parts", [] { return clean(make_touching_parts()); }},
    Entry{"overlapping-parts", [] { return clean(make_overlapping_parts(1)); }},
    Entry{"overlapping-parts-2", [] { return clean(make_overlapping_parts(2)); }},
    Entry{"probe-sphere", [] { return with_probe(clean(ball()), 0.005); }},
    Entry{"probe-bumpy", [] { return with_probe(clean(bumps()), 0.005); }},
    Entry{"probe-star", [] { return with_probe(clean(make_star()), 0.01); }},
    Entry{"probe-staircase", [] { return with_probe(clean(make_staircase(kExtent, 8, 4)), 0.005); }},
    Entry{"probe-cracks", [] { return with_probe(dirty(cracked(ball(), 1e-5), ball()), 0.005); }},
    Entry{"probe-t-junctions", [] { return with_probe(dirty(with_t_junctions(ball(), 1e-5), ball()), 0.005); }},
    Entry{"probe-room", [] { return room_of(askew(make_box(Vec3(0.6, 0.5, 0.4) * kExtent, 2)), 0.02); }},
};

constexpr auto kNames = [] {
  std::array<std::string_view, kBodies.size()> names;
  for (std::size_t i = 0; i < names.size(); ++i) names[i] = kBodies[i].name;
  return names;
}();

}  // namespace

std::span<const std::string_view> stress_body_names() { return kNames; }

StressBody make_stress_body(std::string_view name) {
  for (const Entry& entry : kBodies) {
    if (entry.name != name) continue;
    StressBody body = entry.make();
    body.name = name;
    return body;
  }
  return {};
}

StressBody make_stress_body(std::string name, TriangleMesh mesh) {
  StressBody body{.name = std::move(name), .touched = std::move(mesh), .solid = {}};
  if (count_edges(body.touched).closed()) body.solid = body.touched;
  return body;
}

StressBody placed(StressBody body, double scale, const Vec3& move_m) {
  body.touched = scaled_and_moved(std::move(body.touched), scale, move_m);
  body.solid = scaled_and_moved(std::move(body.solid), scale, move_m);
  return body;
}

}  // namespace hapton
