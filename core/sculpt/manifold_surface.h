#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/sculpt/surface_nets.h"

namespace hapton {

// Positions in spacings of the grid, relative to its first node; quads counter-clockwise seen from outside.
struct ManifoldSurface {
  std::vector<Eigen::Vector3f> positions;
  std::vector<std::array<std::uint32_t, 4>> quads;
};

// The surface of value zero as SurfaceNets has it, but a closed 2-manifold: each edge has two quads, and the quads around a vertex are one
// fan. Where several pieces of surface pass through one cell, SurfaceNets joins them in one vertex; here each piece has its own, at the
// mean of its crossings with the cell's edges. All other vertices are those of SurfaceNets to the last bit. Pieces may still touch or
// intersect each other within a cell.
//
// Method: dual marching cubes (Nielson 2004, "Dual marching cubes"). Where the corners of a cell's face alternate between inside and
// outside, two pieces of contour in it separate the inside corners. If, in each of the two cells at the face, both belong to one piece of
// surface, four quads would share an edge: there they separate the outside corners (Wenger 2013, "Isosurfaces"). A cell has one such face.
//
// Pre: the nodes at the border of the grid are outside. RT: no.
ManifoldSurface make_manifold_surface(const NodeValues& grid);

}  // namespace hapton
