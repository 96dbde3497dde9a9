#pragma once

#include <cstddef>
#include <vector>

#include "core/geometry/triangle_mesh.h"
#include "core/math/types.h"

namespace hapton {

// Points whose convex hull covers a part of a solid.
using ConvexPiece = std::vector<Vec3>;

// Splits a solid into parts whose convex hulls together are the solid up to max_concavity: the least convex part is cut across an axis,
// along the wall of its notch or in the middle, until no part has a point above the plane of one of its triangles by more, or until there
// are most_pieces. The hulls cover the whole surface, and fill shallower notches. Frame and unit: the mesh's. Pre: a closed surface whose
// triangles face outwards; max_concavity and most_pieces above 0. comparisons: if not null, receives how many points and boxes of points
// were compared with planes; the time is proportional to it, near linear in the triangles for each level of cuts. RT: set-up only. Source:
// the idea of approximate convex decomposition (J.-M. Lien, N. Amato, 2006), with axis-aligned cuts.
std::vector<ConvexPiece> split_into_convex(const TriangleMesh& mesh, double max_concavity, std::size_t most_pieces,
                                           std::size_t* comparisons = nullptr);

}  // namespace hapton
