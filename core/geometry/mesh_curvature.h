#pragma once

#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// The mean curvature at each vertex, 1/m: positive where the surface is convex as seen from the front of its triangles, so 1/r on a sphere
// of radius r. NaN where it is not known: at vertices of a boundary edge, a non-manifold edge or an edge to a flipped triangle, and at
// those without a triangle that has an area. On a smooth surface the error falls with the square of the edge length only at vertices with
// regular triangles; at others an error of some per cent remains, and a much larger one with obtuse triangles. Pre: vertices are welded.
// Units: metres. RT: no. Source: Meyer, Desbrun, Schröder & Barr, Discrete Differential-Geometry Operators (2003), eq. 8, fig. 4 (area).
std::vector<double> compute_mean_curvature(const TriangleMesh& mesh);

}  // namespace hapton
