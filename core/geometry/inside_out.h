#pragma once

#include <cstddef>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Closed bodies of a mesh: pieces that share no vertex with one another, in which each edge is traversed equally often in both directions.
// Triangles that have a vertex twice belong to no piece, and join none.
struct ClosedBodies {
  std::size_t count = 0;
  std::size_t others = 0;      // pieces that are open or have no volume
  std::size_t inside_out = 0;  // bodies with the fronts inside, except cavities: those inside the box of a body with its front outside
  Vec3 inside_out_at = Vec3::Zero();  // centre of the box of the largest of those bodies, in the frame of the mesh; zero if there is none
  std::size_t comparisons = 0;        // boxes that were compared to tell cavities from bodies that are inside out (EnclosingBoxes)
};

// Pre: vertices are welded. Time: linear in the mesh, and n log n in its closed bodies where few of their boxes overlap partly. RT: set-up
// only.
ClosedBodies count_closed_bodies(const TriangleMesh& mesh);

// For each triangle, whether it belongs to a closed body with its fronts outside, so that its back is never seen; for a triangle that has a
// vertex twice, whether its first vertex does. Pre: vertices are welded. Time: linear. RT: set-up only.
std::vector<bool> find_outward_triangles(const TriangleMesh& mesh);

}  // namespace hapton
