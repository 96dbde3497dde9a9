#include "core/geometry/repair_mesh.h"

#include <fmt/core.h>

#include <algorithm>
#include <numeric>

#include "core/geometry/key_table.h"
#include "core/geometry/shared_edges.h"

namespace hapton {
namespace {

constexpr double kNeedleHeight = 0.01;  // height below which a triangle is a needle, over its longest edge

// The triangle with its lowest-numbered vertex first, in the same cyclic order.
KeyTable<3>::Key rotated(const Triangle& t) {
  const auto k = std::min_element(t.begin(), t.end()) - t.begin();
  return {t[k], t[(k + 1) % 3], t[(k + 2) % 3]};
}

void weld(TriangleMesh& mesh, RepairReport& report, std::vector<std::uint32_t>& source) {
  KeyTable<3> numbers(mesh.vertices.size());
  std::vector<std::uint32_t> renumbered(mesh.vertices.size());
  std::uint32_t used = 0;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    renumbered[i] = numbers.find_or_add(words_of(mesh.vertices[i]), used);
    if (renumbered[i] == used) {
      source.push_back(static_cast<std::uint32_t>(i));
      mesh.vertices[used++] = mesh.vertices[i];
    } else {
      ++report.welded_vertices;
    }
  }
  mesh.vertices.resize(used);
  if (report.welded_vertices == 0) return;
  for (Triangle& t : mesh.triangles) {
    for (std::uint32_t& v : t) v = renumbered[v];
  }
}

void drop_useless(TriangleMesh& mesh, RepairReport& report, std::vector<std::uint32_t>& source) {
  KeyTable<3> numbers(mesh.triangles.size());
  std::size_t kept = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Triangle t = mesh.triangles[i];
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) {
      ++report.dropped_empty;
      continue;
    }
    const auto number = static_cast<std::uint32_t>(i);
    if (numbers.find_or_add(rotated(t), number) != number) {
      ++report.dropped_duplicates;
      continue;
    }
    if (numbers.contains(rotated({t[0], t[2], t[1]}))) ++report.double_faces;
    source[kept] = static_cast<std::uint32_t>(i);
    if (i < mesh.authored_normals.size()) mesh.authored_normals[kept] = mesh.authored_normals[i];
    mesh.triangles[kept++] = t;
  }
  mesh.triangles.resize(kept);
  if (!mesh.authored_normals.empty()) mesh.authored_normals.resize(kept, {});
  source.resize(kept);
}

void count_thin(const TriangleMesh& mesh, RepairReport& report) {
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Vec3 ab = mesh.corner(i, 1) - mesh.corner(i, 0);
    const Vec3 ac = mesh.corner(i, 2) - mesh.corner(i, 0);
    const double longest = std::max({ab.squaredNorm(), ac.squaredNorm(), (ac - ab).squaredNorm()});
    const double area = ab.cross(ac).norm();
    if (area <= 1e-14 * longest) {
      ++report.empty_area;
    } else if (area < kNeedleHeight * longest) {
      ++report.needles;
    }
  }
}

// Orients every piece consistently, where that is possible.
void orient_pieces(TriangleMesh& mesh, const SharedEdges& edges, RepairReport& report) {
  enum : std::uint8_t { unvisited, unchanged, flipped };
  std::vector<std::uint8_t> state(mesh.triangles.size(), unvisited);
  std::vector<std::uint32_t> piece;
  for (std::uint32_t start = 0; start < mesh.triangles.size(); ++start) {
    if (state[start] != unvisited) continue;
    ++report.pieces;
    piece.assign(1, start);
    state[start] = unchanged;
    bool is_orientable = true;
    std::size_t flipped_count = 0;
    for (std::size_t i = 0; i < piece.size(); ++i) {
      const std::uint32_t t = piece[i];
      for (int k = 0; k < 3; ++k) {
        const HalfEdge* other = edges.adjacent(t, k);
        if (other == nullptr) continue;
        const bool is_upward = mesh.triangles[t][k] < mesh.triangles[t][(k + 1) % 3];
        const bool is_same_direction =
            is_upward == other->upward;  // consistently oriented triangles traverse their common edge in opposite directions
        const std::uint8_t required = (state[t] == flipped) != is_same_direction ? flipped : unchanged;
        if (state[other->triangle] == unvisited) {
          state[other->triangle] = required;
          flipped_count += required == flipped ? 1 : 0;
          piece.push_back(other->triangle);
        } else if (state[other->triangle] != required) {
          is_orientable = false;
        }
      }
    }
    if (!is_orientable) {
      ++report.unorientable_pieces;
      continue;
    }
    if (flipped_count == 0) continue;
    const std::uint8_t minority = 2 * flipped_count > piece.size() ? unchanged : flipped;
    for (const std::uint32_t t : piece) {
      if (state[t] != minority) continue;
      std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
      if (!mesh.authored_normals.empty()) std::swap(mesh.authored_normals[t][1], mesh.authored_normals[t][2]);
      ++report.turned;
    }
  }
}

}  // namespace

TriangleMesh repair_mesh(const TriangleMesh& mesh, RepairReport& report, std::vector<std::uint32_t>* source,
                         std::vector<std::uint32_t>* vertex_source) {
  report = {};
  TriangleMesh repaired = mesh;
  std::vector<std::uint32_t> from(mesh.triangles.size());
  std::iota(from.begin(), from.end(), 0U);
  std::vector<std::uint32_t> vertex_from;
  weld(repaired, report, vertex_from);
  drop_useless(repaired, report, from);
  count_thin(repaired, report);
  const SharedEdges edges(repaired.triangles);
  for (std::size_t e = 0; e < edges.size(); ++e) {
    report.boundary_edges += edges[e].size() == 1 ? 1 : 0;
    report.nonmanifold_edges += edges[e].size() > 2 ? 1 : 0;
  }
  orient_pieces(repaired, edges, report);
  if (source != nullptr) *source = std::move(from);
  if (vertex_source != nullptr) *vertex_source = std::move(vertex_from);
  return repaired;
}

std::string RepairReport::describe() const {
  return fmt::format(
      "repair: welded {} vertices, dropped {} empty and {} duplicate triangles, reversed {}; left: {} double faces, {} with collinear "
      "corners, "
      "{} needles, {} boundary edges, {} non-manifold edges, {} of {} pieces unorientable",
      welded_vertices, dropped_empty, dropped_duplicates, turned, double_faces, empty_area, needles, boundary_edges, nonmanifold_edges,
      unorientable_pieces, pieces);
}

}  // namespace hapton
