#pragma once

#include "core/force/reference/triangle_boxes.h"
#include "core/geometry/triangle_mesh.h"
#include "core/math/types.h"

namespace hapton {

// Whether a point that may not cross the mesh certainly has its local minimum near `proxy` when the device is at `device`. True is a proof,
// up to rounding; false says nothing.
// Within `radius` of the proxy the free side must be convex: every edge in that ball is a concave edge of exactly two faces (no boundary).
// Then the intersection of the faces' half-spaces has one point nearest to the device, and that must be within half of `radius` of the
// proxy. boxes: those of the mesh's triangles, each of which is tested. All in one frame and unit. RT: no.
bool is_certain_minimum(const TriangleMesh& mesh, TriangleBoxes& boxes, const Vec3& proxy, const Vec3& device, double radius);

}  // namespace hapton
