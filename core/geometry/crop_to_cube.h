#pragma once

#include <cstdint>
#include <span>

#include "core/geometry/triangle_mesh.h"
#include "core/math/types.h"

namespace hapton {

// The parts of the given triangles of a mesh that lie in a cube, moved so that the cube's centre is the origin. A method whose tolerances
// scale with its scene then resolves smaller features than in the whole mesh. Triangles are cut at the sides of the cube; their vertices
// are not shared. A triangle that touches the cube at most in a point or an edge is left out. Triangles inside the cube keep their shape up
// to the rounding of the subtraction. RT: no.
TriangleMesh crop_to_cube(const TriangleMesh& mesh, std::span<const std::uint32_t> triangles, const Vec3& centre, double half_side);

}  // namespace hapton
