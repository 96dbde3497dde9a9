#pragma once

#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// The mean curvature at each vertex, 1/m: positive where the surface is convex as seen from the front of its triangles, so 1/r on a sphere
// of radius r. NaN where it is not known: at boundary edges, edges of more than two triangles, and vertices of no triangle with an area.
// The indices must be welded. The error on a smooth surface is of the second order in edge length times curvature, if triangles are not
// needles. Units: metres. RT: no. Source: Meyer, Desbrun, Schröder & Barr, Discrete Differential-Geometry Operators (2003), eq. 8, with
// the mixed area of their fig. 4.
std::vector<double> compute_mean_curvature(const TriangleMesh& mesh);

}  // namespace hapton
