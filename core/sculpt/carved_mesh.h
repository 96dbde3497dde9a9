#pragma once

#include "core/geometry/triangle_mesh.h"
#include "core/sculpt/carved_field.h"

namespace hapton {

// The surface of a body as a mesh, for other programs: that of the finest level that vision_node draws (SurfaceNets), with two triangles
// for each quad and each vertex once. No edge is open; where two pieces of surface meet within one cell, four triangles may share an edge.
// Frame: that of the field. Metres. Without triangles if nothing is left. RT: no.
TriangleMesh make_carved_mesh(const CarvedField& field);

}  // namespace hapton
