#pragma once

#include <optional>

#include "core/math/types.h"
#include "core/sculpt/carved_field.h"

namespace hapton {

// The point of the surface of a field, its zero set, that is closest to p; none: the field has no surface. In each cell of the grid the
// surface is taken as the triangles that six tetrahedra of the cell give, whose corners are on it, and the point found goes from there to
// the zero set. So a farther point is found only where it is farther by less than h^2 / r of a surface of radius r, h a spacing. Time: that
// of a search of all cells within twice the distance: 50 us for a distance of six spacings. Pre: p is finite. Frame, units: the field's.
// RT: no. Threads: any number, while none carves.
std::optional<Vec3> find_closest_surface_point(const CarvedField& field, const Vec3& p);

}  // namespace hapton
