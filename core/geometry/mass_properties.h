#pragma once

#include <optional>

#include "core/geometry/triangle_mesh.h"
#include "core/math/types.h"

namespace hapton {

// Of a solid of uniform density within a closed surface. Frame and unit: the mesh's.
struct MassProperties {
  double volume = 0.0;
  Vec3 centre = Vec3::Zero();            // of mass
  Mat3 inertia_per_mass = Mat3::Zero();  // about the centre, divided by the mass: length squared
};

// Integrals over the tetrahedra between the triangles and the centre of the bounding box (B. Mirtich, "Fast and accurate computation of
// polyhedral mass properties", 1996, has the same integrals by another way). Nothing: the surface is not closed, its triangles do not all
// face outwards (those of a cavity face into it), or its volume is no more than rounding may leave. Pre: vertices are welded. RT: set-up
// only.
std::optional<MassProperties> compute_mass_properties(const TriangleMesh& mesh);

}  // namespace hapton
