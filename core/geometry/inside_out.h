#pragma once

#include <cstddef>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Closed bodies of a mesh: pieces that share no vertex, in which each edge is traversed equally often in both directions. Triangles that
// have a vertex twice belong to none, and join none.
struct ClosedBodies {
  std::size_t count = 0;
  std::size_t others = 0;             // pieces that are open, or without volume
  std::size_t inside_out = 0;         // with the fronts inside; a cavity, inside the box of a body with its front outside, does not count
  Vec3 inside_out_at = Vec3::Zero();  // middle of the box of the largest of those; the mesh's frame. Zero: there is none
  std::size_t compared = 0;           // boxes that were compared to tell cavities from those (EnclosingBoxes)
};

// Vertices must be welded already. Time: linear in the mesh, and n log n in its closed bodies where few of their boxes overlap partly. RT:
// set-up only.
ClosedBodies count_closed_bodies(const TriangleMesh& mesh);

// By triangle: it belongs to a closed body with its fronts outside, so that its back is never seen. Vertices must be welded already. Time:
// linear. RT: set-up only.
std::vector<bool> find_outward_triangles(const TriangleMesh& mesh);

}  // namespace hapton
