#pragma once

#include <optional>

#include "core/math/types.h"
#include "core/sculpt/carved_field.h"

namespace hapton {

// The point of the surface of a field (its zero set) that is closest to p; none: the field has no surface. In each cell of the grid, six
// tetrahedra give triangles that approximate the surface; the closest point of all triangles is then moved onto the zero set. The result
// may be farther than the closest point by less than h^2 / r, with h the grid's spacing and r the radius of curvature of the surface.
// Time: a search of all cells within twice the distance, 50 us for a distance of six spacings. Pre: p is finite. Frame, units: the field's.
// RT: no. Threads: any number, while none of them carves.
std::optional<Vec3> find_closest_surface_point(const CarvedField& field, const Vec3& p);

}  // namespace hapton
