#pragma once

#include "core/force/reference/triangle_boxes.h"
#include "core/geometry/triangle_mesh.h"
#include "core/math/types.h"

namespace hapton {

// Whether a point that may not cross the mesh certainly has its local minimum near `proxy` when the device is at `device`. True is a proof,
// up to rounding; false says nothing.
// Within `radius` of the proxy the free side must be convex: every edge there joins two faces that form a concave edge, and no face ends.
// Then the intersection of the faces' half-spaces has one point nearest to the device, and that must be within half of `radius` of the
// proxy. Tests every triangle; boxes: of them. All in one frame and unit. RT: no.
bool is_certain_minimum(const TriangleMesh& mesh, TriangleBoxes& boxes, const Vec3& proxy, const Vec3& device, double radius);

}  // namespace hapton
