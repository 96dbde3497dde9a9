#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Result of sealing the cracks of a mesh.
struct SealReport {
  std::size_t welded_vertices = 0;  // moved onto another vertex
  std::size_t split_triangles = 0;  // cuts at a vertex on the edge of another triangle; each adds a triangle
  std::size_t zipped_edges = 0;     // boundary edges joined in pairs
  double widest_gap = 0.0;          // widest gap that was sealed, the mesh's units
  double tolerance = 0.0;           // largest gap counted as a crack, the mesh's units
  std::size_t boundary_edges = 0;   // before
  std::size_t boundary_edges_left = 0;
  std::size_t unsealed_edges = 0;  // of these: of gaps no wider than the tolerance, as count_boundary_edges counts them
  double widest_unsealed = 0.0;    // of those
  bool has_given_up = false;       // too many vertices and edges lie within the tolerance of one another: nothing was sealed

  bool has_sealed() const { return welded_vertices + split_triangles > 0; }
  bool is_worth_a_note() const { return has_sealed() || has_given_up || unsealed_edges > 0; }
  // One line, for meshes in metres: "sealed cracks up to 1.2e-05 m wide: ...".
  std::string describe() const;
};

// Widest crack that is sealed, as a share of the longest side of the mesh's box.
constexpr double kSealedShare = 1e-4;

// Seals cracks and T-junctions no wider than share times the longest side: boundary vertices are welded and boundary edges split where
// another boundary has a vertex, until edges that ran side by side are one. A mesh without any is returned unchanged to the bit; a boundary
// without another one alongside within the tolerance stays, and nothing but boundary is moved.
//
// Where there is a choice, the nearest vertices are joined first, and first those surfaces that continue smoothly with one orientation,
// then those of opposite orientation (both keep it), then those that fold back sharply.
//
// Post, compared with the given mesh:
// - every vertex is one of those given, none was moved by more than the tolerance;
// - no triangle lost its area or its side: each is unchanged, or turned by less than 90 degrees, or split into several that are;
// - no edge has more than two triangles that had not, no two triangles have the same vertices that had not;
// - there are no more boundary edges than before; vertices and triangles keep their order; parts of a split triangle are in its place;
// - authored normals stay with their corners; at a split they are interpolated.
// What could be sealed only by breaking these rules stays open, and so does everything wider; that does not keep other cracks open. Where
// several vertices meet at one place, not all of them within the tolerance of one another, they are welded at one that is near all of the
// others; if there is none, at two that are farther apart than the tolerance.
//
// Sealing again changes nothing. Independent of scale and position up to rounding. Time: n log n in the boundary, linear in the mesh; but
// n^(4/3) for loose triangles as large as the mesh, whose edges each pass that many vertices. Where
// thousands of boundary vertices and edges lie within one tolerance, only the nearest 32 vertices and 256 edges of each are examined; if
// that is too much for all of them together, or repetition does not settle, the mesh is returned unchanged (has_given_up). Pre:
// vertices equal to the bit are one already (or may become so), coordinates finite. RT: set-up only. source[i]: the triangle of the given
// mesh that triangle i was, or is a part of.
TriangleMesh seal_cracks(TriangleMesh mesh, SealReport& report, double share = kSealedShare, std::vector<std::uint32_t>* source = nullptr);

}  // namespace hapton
