#include "core/geometry/inside_out.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/geometry/disjoint_sets.h"
#include "core/geometry/enclosing_boxes.h"

namespace hapton {
namespace {

// A volume below this share of the cubed diagonal of the body's box is rounding: two sheets back to back have no volume.
constexpr double kVolumeShare = 1e-9;

struct Body {
  Eigen::AlignedBox3d box;
  double volume = 0.0;              // positive with the front outside
  std::uint64_t boundary_hash = 0;  // sum of hash_edge() over its edges, signed by direction; 0: closed
  std::size_t triangles = 0;
};

// A pseudo-random number for each edge (the finalizer of splitmix64), so that sums of different edges cancel only with a probability of
// 2^-64.
std::uint64_t hash_edge(std::uint32_t low, std::uint32_t high) {
  std::uint64_t z = (std::uint64_t{high} << 32 | low) + 0x9E3779B97F4A7C15ULL;
  z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9ULL;
  z = (z ^ z >> 27) * 0x94D049BB133111EBULL;
  return z ^ z >> 31;
}

bool is_closed(const Body& body) {
  return body.boundary_hash == 0 && std::abs(body.volume) > kVolumeShare * std::pow(body.box.diagonal().norm(), 3);
}

// A collapsed triangle has no surface, and goes to and fro along an edge: it would join two bodies unnoticed.
bool is_collapsed(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

// All pieces, by the number of the vertex that represents the piece; the entries of other vertices have no triangles.
std::vector<Body> measure_pieces(const TriangleMesh& mesh, DisjointSets& pieces) {
  for (const Triangle& t : mesh.triangles) {
    if (is_collapsed(t)) continue;
    for (const std::size_t k : {1U, 2U}) pieces.join(t[0], t[k]);
  }
  std::vector<Body> bodies(mesh.vertices.size());
  for (const Triangle& t : mesh.triangles) {
    if (is_collapsed(t)) continue;
    Body& body = bodies[pieces.root(t[0])];
    ++body.triangles;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(t[k], t[(k + 1) % 3]);
      body.boundary_hash += low == t[k] ? hash_edge(low, high) : 0 - hash_edge(low, high);
      body.box.extend(mesh.vertices[t[k]]);
    }
  }
  // Positions are relative to the centre of the body's box, so that a small body far from the origin keeps its digits.
  for (const Triangle& t : mesh.triangles) {
    Body& body = bodies[pieces.root(t[0])];
    const Vec3 centre = body.box.center();
    const Vec3 a = mesh.vertices[t[0]] - centre;
    body.volume += a.dot((mesh.vertices[t[1]] - centre).cross(mesh.vertices[t[2]] - centre)) / 6.0;
  }
  return bodies;
}

std::vector<Body> find_bodies(const TriangleMesh& mesh) {
  DisjointSets pieces(mesh.vertices.size());
  std::vector<Body> bodies = measure_pieces(mesh, pieces);
  std::erase_if(bodies, [](const Body& body) { return body.triangles == 0; });
  return bodies;
}

}  // namespace

ClosedBodies count_closed_bodies(const TriangleMesh& mesh) {
  std::vector<Body> bodies = find_bodies(mesh);
  const std::size_t others = std::erase_if(bodies, [](const Body& body) { return !is_closed(body); });
  std::vector<Eigen::AlignedBox3d> outward;
  for (const Body& body : bodies) {
    if (body.volume > 0.0) outward.push_back(body.box);
  }
  EnclosingBoxes outward_boxes(std::move(outward));
  ClosedBodies result{.count = bodies.size(), .others = others};
  const Body* largest = nullptr;
  for (const Body& body : bodies) {
    if (body.volume > 0.0 || outward_boxes.contain(body.box)) continue;
    ++result.inside_out;
    if (largest == nullptr || body.box.volume() > largest->box.volume()) largest = &body;
  }
  if (largest != nullptr) result.inside_out_at = largest->box.center();
  result.comparisons = outward_boxes.comparisons();
  return result;
}

std::vector<bool> find_outward_triangles(const TriangleMesh& mesh) {
  DisjointSets pieces(mesh.vertices.size());
  const std::vector<Body> bodies = measure_pieces(mesh, pieces);
  std::vector<bool> outward;
  outward.reserve(mesh.triangles.size());
  for (const Triangle& t : mesh.triangles) {
    const Body& body = bodies[pieces.root(t[0])];
    outward.push_back(is_closed(body) && body.volume > 0.0);
  }
  return outward;
}

}  // namespace hapton
