#pragma once

#include <optional>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Touch has a resolution: what is nearer than `width` cannot be told apart there. Without triangles no wider than that, without copies of a
// triangle (same vertices, same way round), and with cracks up to `width` sealed (seal_cracks.h), a surface is the same to the touch, and
// connected where it is one. None where nothing of that is there.
// Where a triangle that is left out would leave a hole, only those go that are no wider than `no_height`: a hole as narrow is tight.
//
// Frame and units: the mesh's. Time: n log n. RT: set-up only.
std::optional<TriangleMesh> resolve_for_touch(const TriangleMesh& mesh, double width, double no_height);

}  // namespace hapton
