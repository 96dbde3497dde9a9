#pragma once

#include "core/geometry/triangle_mesh.h"
#include "core/math/types.h"

namespace hapton {

// Whether a point that may not cross the mesh rests near `proxy` for certain when it is drawn to `device`: within `reach` of the proxy the
// free side is convex (every edge there joins two faces that lean towards the proxy, and nothing ends), so what the planes of the faces
// leave free has one nearest point to the device, and that is within half of `reach` of the proxy. True is a proof, up to rounding; false
// says nothing. Every triangle is asked. All in one frame and unit. RT: no.
bool is_certain_rest(const TriangleMesh& mesh, const Vec3& proxy, const Vec3& device, double reach);

}  // namespace hapton
