#pragma once

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Merges all vertices with equal coordinates into one (0 and -0 are equal), drops those that no triangle uses, and numbers the rest in the
// order of their first use. Triangles keep their order and corners; some may become degenerate. Expected time: linear. Pre: every index in
// range, fewer than 2^32 - 1 vertices. RT: set-up only.
void weld_vertices(TriangleMesh& mesh);

// Drops unused vertices and numbers the rest likewise, without merging. RT: set-up only.
void drop_unused_vertices(TriangleMesh& mesh);

}  // namespace hapton
