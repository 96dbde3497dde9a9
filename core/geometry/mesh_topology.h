#pragma once

#include <cstddef>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Connectivity and quality of the triangles of a mesh. Vertices must be welded already.
struct MeshTopology {
  std::size_t triangles = 0;
  std::size_t vertices = 0;              // vertices of a triangle; others are not counted
  std::size_t boundary_edges = 0;        // edges of one triangle
  std::size_t nonmanifold_edges = 0;     // edges of more than two triangles
  std::size_t inconsistent_edges = 0;    // edges that two triangles traverse in the same direction: one of the two is flipped
  std::size_t nonmanifold_vertices = 0;  // vertices whose triangles form several fans
  std::size_t degenerate_triangles = 0;  // those with a repeated vertex, or an area <= 1e-14 times the longest edge squared
  std::size_t needle_triangles = 0;      // those with a height over the longest edge below 1 % of it, except degenerate ones
  std::size_t duplicate_triangles = 0;   // those with the same three vertices as an earlier one
  std::size_t components = 0;            // pieces that share no vertex
  Vec3 lowest = Vec3::Zero();            // the lowest corner of the bounding box, in the mesh's units
  Vec3 highest = Vec3::Zero();           // the highest corner
  double signed_volume = 0.0;            // between the surface and the origin; for a closed mesh its volume, negative if inside out
  double shortest_edge = 0.0;
  double median_edge = 0.0;
  double longest_edge = 0.0;

  // A watertight, consistently oriented surface, so inside and outside are defined.
  bool is_closed() const {
    return triangles > 0 && boundary_edges + nonmanifold_edges + inconsistent_edges + nonmanifold_vertices + degenerate_triangles == 0;
  }
};

// Linear in the mesh's size. RT: set-up only.
MeshTopology compute_mesh_topology(const TriangleMesh& mesh);

}  // namespace hapton
