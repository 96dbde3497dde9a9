#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Meshes like those that CAD systems export, generated for `hapton stress`: pure functions of their arguments, in metres; but for
// make_cell_solid, longest side about 0.1 m, near the origin. RT: set-up only.

// Five long thin spikes from a small core: sharp vertices and deep concave edges.
TriangleMesh make_star();

// The boundary of the grid cells for which `is_solid` is true: closed, consistently oriented, welded. Pre: grid lines ascend; no two
// solid cells share only an edge or a vertex. is_solid is asked about cells of the grid only.
TriangleMesh make_cell_solid(const std::vector<double>& x_m, const std::vector<double>& y_m, const std::vector<double>& z_m,
                             const std::function<bool(int, int, int)>& is_solid);

// A closed block with slots across it, undercuts from its sides and blind pockets, 0.1 % to 3 % of the longest side wide: most of its
// surface is in gaps, most triangles are slivers. bend_radius_m > 0 bends it about the y axis: walls of a slot are then not parallel.
TriangleMesh make_slotted_part(std::uint64_t seed, double bend_radius_m);

// The front of a car as modelled for rendering: open panels with gaps, some flipped, in part or as a whole; behind some a coarser inner
// panel, which intersects it in places; ribs and closed lamps through the panels; one panel again, flipped. It has no inside.
TriangleMesh make_open_front(std::uint64_t seed);

// Closed parts whose faces coincide exactly: bricks triangulated differently on their common faces, a cylinder standing on them, and a
// hollow box with a pane on the inside of its wall.
TriangleMesh make_touching_parts();

// Closed parts that intersect: boxes, cylinders, spheres and tori in any pose; one is there twice, one again 1e-10 to 1e-5 extents away.
TriangleMesh make_overlapping_parts(std::uint64_t seed);

}  // namespace hapton
