#pragma once

#include "core/geometry/triangle_mesh.h"
#include "core/math/types.h"

namespace hapton {

// How often a closed mesh winds round p: 1 inside a body whose faces point outwards, 0 outside, the sum over all bodies where they overlap.
// Computed from the solid angles of all triangles, so it needs no ray direction and is right as near to the surface as rounding allows; on
// the surface itself it lies between the values on its two sides. Frame and units: any, the same for mesh and p. RT: no. Source: solid
// angle of a triangle, Van Oosterom & Strackee (1983).
double compute_winding_number(const TriangleMesh& mesh, const Vec3& p);

}  // namespace hapton
