#pragma once

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Makes one of all vertices whose coordinates are equal to the bit (0 and -0 count as equal), drops those no triangle uses,
// and numbers the rest by first use. Triangles keep their order and corners; some may become degenerate.
// Linear time. Pre: every index in range, fewer than 2^32 - 1 vertices. RT: set-up only.
void weld_vertices(TriangleMesh& mesh);

// Only the dropping and numbering.
void drop_unused_vertices(TriangleMesh& mesh);

}  // namespace hapton
