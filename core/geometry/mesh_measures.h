#pragma once

#include <cstddef>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Counts of the mesh's edges, from its welded indices alone. RT: none of this header.
struct EdgeCensus {
  std::size_t edges = 0;         // undirected, both ends different
  std::size_t boundary = 0;      // used by one triangle
  std::size_t non_manifold = 0;  // used by three or more
  std::size_t inconsistent = 0;  // used by two triangles in the same direction
  bool closed() const { return edges > 0 && boundary == 0 && non_manifold == 0 && inconsistent == 0; }
};

EdgeCensus count_edges(const TriangleMesh& mesh);

// Signed volume in cubic metres, positive if the normals of a closed mesh point outwards. Computed about the box centre, so an offset costs
// no digits.
double compute_volume(const TriangleMesh& mesh);

// Total area in square metres.
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
