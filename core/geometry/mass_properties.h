#pragma once

#include <optional>

#include "core/geometry/triangle_mesh.h"
#include "core/math/types.h"

namespace hapton {

// The volume, centre of mass and inertia of a solid of uniform density within a closed surface. Frame and unit: those of the mesh.
struct MassProperties {
  double volume = 0.0;
  Vec3 centre = Vec3::Zero();            // the centre of mass
  Mat3 inertia_per_mass = Mat3::Zero();  // the inertia about the centre of mass, divided by the mass: in units of length squared
};

// Sums integrals over the tetrahedra between the triangles and the centre of the bounding box (B. Mirtich, "Fast and accurate computation
// of polyhedral mass properties", 1996, computes the same integrals in another way). Returns nothing if the surface is not closed, if its
// triangles do not all face outwards (those of a cavity face into the cavity), or if its volume is no larger than rounding may leave. Pre:
// vertices are welded. RT: set-up only.
std::optional<MassProperties> compute_mass_properties(const TriangleMesh& mesh);

}  // namespace hapton
