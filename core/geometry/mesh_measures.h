#pragma once

#include <cstddef>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Counts of the edges of a mesh, from its welded indices alone. RT: nothing in this header.
struct EdgeCensus {
  std::size_t edges = 0;         // all edges, regardless of direction, whose ends are two vertices
  std::size_t boundary = 0;      // edges of one triangle
  std::size_t non_manifold = 0;  // edges of three or more triangles
  std::size_t inconsistent = 0;  // edges that two triangles traverse in the same direction
  bool closed() const { return edges > 0 && boundary == 0 && non_manifold == 0 && inconsistent == 0; }
};

EdgeCensus count_edges(const TriangleMesh& mesh);

// The signed volume in cubic metres, positive if the normals of a closed mesh point outwards. Computed relative to the centre of the box,
// so that no digits are lost for a mesh far from the origin.
double compute_volume(const TriangleMesh& mesh);

// The total area in square metres.
double compute_area(const TriangleMesh& mesh);

// The axis-aligned box of all vertices. An empty mesh has low > high.
struct MeshBounds {
  Vec3 low;
  Vec3 high;
  Vec3 centre() const { return 0.5 * low + 0.5 * high; }
  double diagonal() const { return (high - low).norm(); }
  double extent() const { return (high - low).maxCoeff(); }  // the longest side
};

MeshBounds compute_bounds(const TriangleMesh& mesh);

}  // namespace hapton
