#pragma once

#include "core/geometry/triangle_mesh.h"
#include "core/math/types.h"

namespace hapton {

// How often a closed mesh winds round p: 1 inside a body whose faces point outwards, 0 outside, the sum of all bodies where they overlap.
// Computed from the solid angles of all triangles, so it needs no ray direction and is right as near to the surface as rounding allows; on
// the surface itself it is between. Frame and units: any, of both the same. RT: no. Source: solid angle of a triangle, Van Oosterom &
// Strackee (1983).
double compute_winding_number(const TriangleMesh& mesh, const Vec3& p);

}  // namespace hapton
