#pragma once

#include <cstddef>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// How the triangles of a mesh hang together, and how well they are shaped. Vertices are taken as welded already.
struct MeshTopology {
  std::size_t triangles = 0;
  std::size_t vertices = 0;              // used by a triangle
  std::size_t boundary_edges = 0;        // of one triangle
  std::size_t nonmanifold_edges = 0;     // of more than two
  std::size_t inconsistent_edges = 0;    // of two that run the same way along it: one of them is turned round
  std::size_t nonmanifold_vertices = 0;  // whose triangles fall apart into several fans
  std::size_t degenerate_triangles = 0;  // a repeated vertex, or area <= 1e-14 times the longest edge squared
  std::size_t needle_triangles = 0;      // height over the longest edge below 1 % of it, degenerate ones left out
  std::size_t duplicate_triangles = 0;   // same three vertices as an earlier one
  std::size_t components = 0;            // pieces that share no vertex
  Vec3 lowest = Vec3::Zero();            // corners of the bounding box, the mesh's units
  Vec3 highest = Vec3::Zero();
  double signed_volume = 0.0;  // between the surface and the origin; of a closed mesh its volume, negative when inside out
  double shortest_edge = 0.0;
  double median_edge = 0.0;
  double longest_edge = 0.0;

  // A watertight surface of one consistent winding: inside and outside mean something.
  bool is_closed() const {
    return triangles > 0 && boundary_edges + nonmanifold_edges + inconsistent_edges + nonmanifold_vertices + degenerate_triangles == 0;
  }
};

// Linear in the mesh's size. RT: set-up only.
MeshTopology compute_mesh_topology(const TriangleMesh& mesh);

}  // namespace hapton
