#pragma once

#include "core/geometry/triangle_mesh.h"
#include "core/math/types.h"

namespace hapton {

// The part of a mesh within a cube, moved so that the cube's centre is the origin: there a method that counts in shares of its scene sees
// what is too small for it in the whole. Triangles are cut at the sides of the cube; their vertices are not shared. What lies wholly within
// keeps its shape to the last digit of the difference. RT: no.
TriangleMesh make_close_up(const TriangleMesh& mesh, const Vec3& centre, double half_side);

}  // namespace hapton
