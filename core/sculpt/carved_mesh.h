#pragma once

#include "core/geometry/triangle_mesh.h"
#include "core/sculpt/carved_field.h"

namespace hapton {

// The surface of a body as a mesh, for other programs: a closed 2-manifold, with two triangles for each quad of ManifoldSurface. Except
// where several pieces of surface pass through one cell of the grid, it is the finest level that vision_node draws. Frame: that of the
// field. Metres. Without triangles if nothing is left. RT: no.
TriangleMesh make_carved_mesh(const CarvedField& field);

}  // namespace hapton
