#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Faults found in a mesh and what was done about them.
struct RepairReport {
  std::size_t welded_vertices = 0;     // equal to the bit (0 and -0 are equal), merged
  std::size_t dropped_empty = 0;       // triangles that repeat a vertex: no area, no edge of their own
  std::size_t dropped_duplicates = 0;  // same three vertices in the same order as an earlier one
  std::size_t turned = 0;              // flipped so that their piece is consistently oriented
  // Only counted: no safe repair exists.
  std::size_t double_faces = 0;         // same three vertices as an earlier one in reverse order: a sheet with two sides
  std::size_t empty_area = 0;           // three different vertices on a line: kept, because they close seams
  std::size_t needles = 0;              // height below 1 % of the longest edge
  std::size_t boundary_edges = 0;       // of one triangle: cracks and true boundaries
  std::size_t nonmanifold_edges = 0;    // of three and more
  std::size_t unorientable_pieces = 0;  // no orientation fits all their triangles; left unchanged
  std::size_t pieces = 0;               // connected over edges of two triangles

  std::string describe() const;
};

// Repairs what can be repaired without changing the surface, and counts the rest. Triangles keep their order. source[i]: number of triangle
// i in the given mesh; vertex_source[i]: of vertex i. Orientation: in a piece whose triangles disagree, the minority is flipped; a
// consistent piece stays as it is, inside out or not. RT: set-up only. Source: FDH paper, 4.1 ("problems with more or less
// incorrect triangle models").
TriangleMesh repair_mesh(const TriangleMesh& mesh, RepairReport& report, std::vector<std::uint32_t>* source = nullptr,
                         std::vector<std::uint32_t>* vertex_source = nullptr);

}  // namespace hapton
