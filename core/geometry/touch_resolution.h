#pragma once

#include <optional>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Touch has a resolution: positions nearer than `width` cannot be distinguished. Removes triangles no wider than that and copies of a
// triangle (same vertices, same order), and seals cracks up to `width` (seal_cracks.h): for touch the surface is the same, and connected.
// Empty if there is nothing to do. Where removing a triangle would leave a hole, only triangles no wider than `no_height` are removed: a
// hole as narrow lets nothing through.
//
// Frame and units: the mesh's. Time: n log n. RT: set-up only.
std::optional<TriangleMesh> resolve_for_touch(const TriangleMesh& mesh, double width, double no_height);

}  // namespace hapton
