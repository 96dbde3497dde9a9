#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Result of sealing the cracks of a mesh.
struct SealReport {
  std::size_t welded_vertices = 0;      // moved onto another vertex
  std::size_t split_triangles = 0;      // splits at a vertex on the edge of another triangle; each adds a triangle
  std::size_t zipped_edges = 0;         // boundary edges joined in pairs
  double widest_gap = 0.0;              // widest gap that was sealed, the mesh's units
  double tolerance = 0.0;               // largest gap that counts as a crack, the mesh's units
  std::size_t boundary_edges = 0;       // boundary edges before sealing
  std::size_t boundary_edges_left = 0;  // boundary edges after sealing
  std::size_t unsealed_edges = 0;       // those of them at gaps no wider than the tolerance, as count_boundary_edges counts them
  double widest_unsealed = 0.0;         // the widest gap at unsealed_edges
  bool has_given_up = false;            // too many vertices and edges lie within the tolerance of one another: nothing was sealed

  bool has_sealed() const { return welded_vertices + split_triangles > 0; }
  bool is_worth_a_note() const { return has_sealed() || has_given_up || unsealed_edges > 0; }
  // One line, for meshes in metres: "sealed cracks up to 1.2e-05 m wide: ...".
  std::string describe() const;
};

// The widest crack that is sealed, as a share of the longest side of the mesh's box.
constexpr double kSealedShare = 1e-4;

// Seals cracks and T-junctions no wider than `share` times the longest side: boundary vertices are welded, and boundary edges split where
// another boundary has a vertex, until edges that ran side by side are one. A mesh without cracks is returned unchanged to the bit. A
// boundary with no other one beside it within the tolerance stays, and only vertices at the boundary are moved.
//
// Where there is a choice, surfaces that continue smoothly with one orientation are joined first, then those of opposite orientation (both
// keep it), then those that fold back sharply; among these, the nearest vertices first.
//
// Post, compared with the given mesh:
// - every vertex is one of those given, none was moved by more than the tolerance;
// - no triangle lost its area or its side: each is unchanged, or turned by less than 90 degrees, or split into several that are;
// - no edge gets more than two triangles, and no two triangles get the same vertices, unless that was so in the given mesh;
// - there are no more boundary edges than before; vertices and triangles keep their order; parts of a split triangle are in its place;
// - authored normals stay with their corners; at a split they are interpolated.
// What could be sealed only by breaking these rules stays open, and so does every wider gap; other cracks are sealed all the same. Where
// several vertices meet at one place, not all within the tolerance of one another, they are welded at a vertex that is near all the others;
// if there is none, at two vertices that are farther apart than the tolerance.
//
// Sealing again changes nothing. The result is independent of scale and position up to rounding. Time: n log n in the boundary and linear
// in the mesh, but n^(4/3) for loose triangles as large as the mesh, each of whose edges passes about n^(1/3) vertices. Where thousands of
// boundary vertices and edges lie within one tolerance, only the nearest 32 vertices and 256 edges of each are examined. If that is too
// much for all of them together, or the repetition does not settle, the mesh is returned unchanged (has_given_up). Pre: vertices that are
// equal to the bit are welded, or may be; coordinates are finite. RT: set-up only. source[i]: the triangle of the given mesh that triangle
// i of the result is, or is a part of.
TriangleMesh seal_cracks(TriangleMesh mesh, SealReport& report, double share = kSealedShare, std::vector<std::uint32_t>* source = nullptr);

}  // namespace hapton
