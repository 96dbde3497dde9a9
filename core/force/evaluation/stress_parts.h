#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Meshes as CAD systems export them, made by rule for `hapton stress`: pure functions of their arguments, in metres, the longest side about
// 0.1 m, about the origin. RT: set-up only.

// The boundary of those cells of a grid that `is_solid` names: closed, consistently oriented, vertices welded. Grid lines ascend.
// Pre: no two solid cells meet in an edge or a vertex alone, and none lies outside the grid.
TriangleMesh make_cell_solid(const std::vector<double>& x_m, const std::vector<double>& y_m, const std::vector<double>& z_m,
                             const std::function<bool(int, int, int)>& is_solid);

// A closed block with slots across it, undercuts from its sides and blind pockets, 0.1 % to 3 % of the longest side wide: most of its
// surface lies in gaps, and most of its triangles are slivers. bend_radius_m > 0 bends it about the y axis, so that no faces are parallel.
TriangleMesh make_slotted_part(std::uint64_t seed, double bend_radius_m);

// The front of a car as it is modelled for pictures: open panels with gaps between them, some turned over, in part or as a whole; coarser
// inner panels close behind them, which come through here and there; ribs and closed lamps through both; one panel twice. No judge of
// inside and outside exists.
TriangleMesh make_open_front(std::uint64_t seed);

// Closed parts whose faces coincide to the last digit: bricks with different triangles on their common faces, a cylinder that stands on
// them, and a hollow box with a pane on the inside of its wall.
TriangleMesh make_touching_parts();

// Closed parts that go through each other: boxes, cylinders, spheres and tori in any pose, one of them twice, one once more as good as in
// the same place.
TriangleMesh make_overlapping_parts(std::uint64_t seed);

}  // namespace hapton
