#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/math/types.h"

namespace hapton {

// Values at the nodes of a grid, negative inside: node (x, y, z) is at x + counts[0] * (y + counts[1] * z).
struct NodeValues {
  std::span<const float> values;
  std::array<int, 3> counts = {};
};

// A piece of surface. Positions in spacings of the grid, relative to its first node; quads counter-clockwise seen from outside.
struct SurfaceNet {
  std::vector<Eigen::Vector3f> positions;
  std::vector<std::array<std::uint32_t, 4>> quads;
};

// The surface of value zero, block by block, by surface nets (Gibson 1998, "Constrained elastic surface nets"): one vertex in each cell
// that the surface passes through, at the mean of its crossings with the cell's edges, and one quad for each edge of the grid that it
// crosses. We omit Gibson's relaxation of the vertices. Blocks fit together: vertices at their borders are the same to the last bit.
//
// With a stride of 2 or 4 only every second or fourth node counts: a coarser surface of a quarter or a sixteenth of the quads. Pre: the
// nodes at the border of the grid are outside. RT: no. Threads: one for each object of this class.
class SurfaceNets {
 public:
  static constexpr int kBlock = 16;         // cells of a block along each axis: what is recomputed after a carve
  static constexpr int kLargestStride = 4;  // a power of two that divides kBlock

  using Index = std::array<int, 3>;

  // The number of blocks along each axis, of a grid with that many nodes.
  static Index count_blocks(const Index& nodes);

  // A box of blocks, first <= block < end. find_changed returns the blocks whose surface, at any stride, depends on the nodes
  // first <= node < end. Pre: first >= 0.
  struct Blocks {
    Index first = {};
    Index end = {};
  };
  static Blocks find_changed(const Index& nodes, const Index& first, const Index& end);

  // Computes the surface in a block into `net`, whose content is replaced. Pre: stride is 1, 2 or 4.
  void compute(const NodeValues& grid, const Index& block, int stride, SurfaceNet& net);

 private:
  bool gather(const NodeValues& grid, const Index& block, int stride);
  void place_vertices(const Index& block, int stride, SurfaceNet& net);
  void place_vertex(const Index& cell, const Index& block, int stride, SurfaceNet& net) const;
  void join_quads(SurfaceNet& net) const;
  int at(int x, int y, int z) const { return x + side_ * (y + side_ * z); }

  int side_ = 0;                       // nodes along an axis: those of the block, one before and one after it
  std::vector<float> values_;          // the values at these nodes
  std::vector<std::uint32_t> vertex_;  // number of a cell's vertex, by the first node of the cell; valid where the surface passes
};

}  // namespace hapton
