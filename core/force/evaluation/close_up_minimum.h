#pragma once

#include "core/force/force_method.h"
#include "core/force/reference/triangle_boxes.h"
#include "core/geometry/triangle_mesh.h"
#include "core/math/types.h"

namespace hapton {

// Whether the reference (point probe, without friction) stays at `start` when its scene is only the part of the mesh in the cube of that
// half side about `centre`. The contact offset is a share of the scene's size, so it is smaller there than in the whole mesh, and the probe
// passes over lower steps only. This distinguishes a proxy that a real but low step holds from one that nothing holds. The cube's sides do
// not block. boxes: of the mesh. RT: no.
bool is_minimum_in_close_up(const TriangleMesh& mesh, TriangleBoxes& boxes, const Material& material, const Vec3& centre, double half_side,
                            const Vec3& start, const Vec3& device);

}  // namespace hapton
