#pragma once

#include <optional>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Touch has a resolution: positions nearer to each other than `width` cannot be distinguished. Removes copies of a triangle (same vertices,
// same order) and triangles whose height over the longest edge is at most `width`, and seals cracks up to `width` (seal_cracks.h): for
// touch the surface is the same, and connected. Empty if there is nothing to do. If the removal may leave a hole, only triangles no higher
// than `negligible_height` are removed from the whole mesh: so narrow a hole lets nothing through.
//
// Frame and units: the mesh's. Time: n log n. RT: set-up only.
std::optional<TriangleMesh> resolve_for_touch(const TriangleMesh& mesh, double width, double negligible_height);

}  // namespace hapton
