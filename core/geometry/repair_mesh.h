#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Faults found in a mesh and what was done about them.
struct RepairReport {
  std::size_t welded_vertices = 0;     // vertices merged into an earlier one that is equal to the bit (0 and -0 are equal)
  std::size_t dropped_empty = 0;       // triangles that repeat a vertex: they have no area, and no edge of their own
  std::size_t dropped_duplicates = 0;  // triangles with the same three vertices in the same order as an earlier one
  std::size_t turned = 0;              // triangles flipped so that their piece is consistently oriented
  // The rest is only counted, because no safe repair exists.
  std::size_t double_faces = 0;         // triangles with the vertices of an earlier one in reverse order: a sheet with two sides
  std::size_t empty_area = 0;           // triangles with three different vertices on a line: kept, because they close seams
  std::size_t needles = 0;              // triangles with a height below 1 % of the longest edge
  std::size_t boundary_edges = 0;       // edges of one triangle: cracks and true boundaries
  std::size_t nonmanifold_edges = 0;    // edges of three or more triangles
  std::size_t unorientable_pieces = 0;  // pieces that cannot be oriented consistently; left unchanged
  std::size_t pieces = 0;               // sets of triangles connected over edges of two triangles

  std::string describe() const;
};

// Repairs what can be repaired without changing the surface, and counts the rest. Triangles keep their order. source[i] and
// vertex_source[i]: the numbers that triangle i and vertex i of the result have in the given mesh. Orientation: in a piece whose triangles
// disagree, the minority is flipped; a consistent piece stays as it is, inside out or not. RT: set-up only. Source: FDH paper, 4.1
// ("problems with more or less incorrect triangle models").
TriangleMesh repair_mesh(const TriangleMesh& mesh, RepairReport& report, std::vector<std::uint32_t>* source = nullptr,
                         std::vector<std::uint32_t>* vertex_source = nullptr);

}  // namespace hapton
