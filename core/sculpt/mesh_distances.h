#pragma once

#include <span>

#include "core/geometry/triangle_mesh.h"
#include "core/sculpt/field_grid.h"

namespace hapton {

// The signed distance from each node to the surface of a mesh, positive outside, limited to [-band_m, band_m]. Inside: the mesh winds round
// the node, so bodies that overlap are one, and one that is inside out counts as well. Distances are exact to the rounding of a float. A
// node within 2^-26 of the mesh's extent of the surface may have the wrong sign. Frame: the mesh's. Pre: the mesh is closed
// (EdgeCensus::closed); band_m > 0; grid.nodes[0] is a multiple of 4; values.size() == grid.size(). RT: set-up only. Time: proportional to
// the nodes plus, for each triangle, the nodes within band_m.
void compute_mesh_distances(const TriangleMesh& mesh, const FieldGrid& grid, double band_m, std::span<float> values);

}  // namespace hapton
