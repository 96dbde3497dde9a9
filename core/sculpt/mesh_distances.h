#pragma once

#include <span>

#include "core/geometry/triangle_mesh.h"
#include "core/sculpt/field_grid.h"

namespace hapton {

// The signed distance from each node to the surface of a mesh, positive outside, limited to [-band_m, band_m]. Inside means that the
// winding number is not 0: bodies that overlap are one, and a mesh that is inside out is a body too. Distances are exact to the rounding of
// a float. A node nearer to the surface than 2^-23 of the mesh's extent may have the wrong sign. Frame: that of the mesh. Pre: the mesh is
// closed (EdgeCensus::closed); band_m > 0; grid.nodes[0] is a multiple of 4; values.size() == grid.size(). RT: set-up only. Time:
// proportional to the nodes plus, for each triangle, the nodes within band_m.
void compute_mesh_distances(const TriangleMesh& mesh, const FieldGrid& grid, double band_m, std::span<float> values);

}  // namespace hapton
