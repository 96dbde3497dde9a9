#pragma once

#include "core/force/force_method.h"
#include "core/force/reference/triangle_boxes.h"
#include "core/geometry/triangle_mesh.h"
#include "core/math/types.h"

namespace hapton {

// Whether the reference (point probe, without friction) stays within a quarter of half_side of `start` when its scene is only the part of
// the mesh in the cube about `centre` with that half side. The contact offset is a share of the scene's size, so in this smaller scene the
// probe can pass over lower steps of the surface only. This tells a proxy held by a real but low step from one that nothing holds. The
// cube's sides are no surface. boxes: those of the mesh's triangles. All in one frame and unit. RT: no.
bool is_minimum_in_close_up(const TriangleMesh& mesh, TriangleBoxes& boxes, const Material& material, const Vec3& centre, double half_side,
                            const Vec3& start, const Vec3& device);

}  // namespace hapton
