#include "core/sculpt/surface_nets.h"

#include <algorithm>
#include <cstddef>

namespace hapton {
namespace {

// The value of a node beyond the grid.
constexpr float kOutside = 1.0F;

}  // namespace

SurfaceNets::Index SurfaceNets::count_blocks(const Index& nodes) {
  Index blocks;
  for (std::size_t axis = 0; axis < 3; ++axis) blocks[axis] = (nodes[axis] + kBlock - 1) / kBlock;
  return blocks;
}

// A block depends on the nodes from one stride before its first cell to the end of its last cell.
SurfaceNets::Blocks SurfaceNets::find_changed(const Index& nodes, const Index& first, const Index& end) {
  const Index count = count_blocks(nodes);
  Blocks changed;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    changed.first[axis] = std::clamp((first[axis] - 1) / kBlock, 0, count[axis]);
    changed.end[axis] = std::clamp((end[axis] - 1 + kLargestStride) / kBlock + 1, changed.first[axis], count[axis]);
    if (end[axis] <= first[axis]) changed.end[axis] = changed.first[axis];
  }
  return changed;
}

void SurfaceNets::compute(const NodeValues& grid, const Index& block, int stride, SurfaceNet& net) {
  net.positions.clear();
  net.quads.clear();
  side_ = kBlock / stride + 2;
  const auto nodes = static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_) * static_cast<std::size_t>(side_);
  values_.resize(nodes);
  vertex_.resize(nodes);
  if (!gather(grid, block, stride)) return;
  place_vertices(block, stride, net);
  join_quads(net);
}

// Copies the values of the block's nodes. False: the surface does not pass through the block.
bool SurfaceNets::gather(const NodeValues& grid, const Index& block, int stride) {
  bool has_inside = false;
  bool has_outside = false;
  float* to = values_.data();
  for (int z = 0; z < side_; ++z) {
    const int gz = block[2] * kBlock + (z - 1) * stride;
    for (int y = 0; y < side_; ++y) {
      const int gy = block[1] * kBlock + (y - 1) * stride;
      const bool is_row = gy >= 0 && gz >= 0 && gy < grid.counts[1] && gz < grid.counts[2];
      const std::size_t row =
          is_row ? static_cast<std::size_t>(grid.counts[0]) *
                       (static_cast<std::size_t>(gy) + static_cast<std::size_t>(grid.counts[1]) * static_cast<std::size_t>(gz))
                 : 0;
      for (int x = 0; x < side_; ++x, ++to) {
        const int gx = block[0] * kBlock + (x - 1) * stride;
        const bool is_node = is_row && gx >= 0 && gx < grid.counts[0];
        *to = is_node ? grid.values[row + static_cast<std::size_t>(gx)] : kOutside;
        (*to < 0.0F ? has_inside : has_outside) = true;
      }
    }
  }
  return has_inside && has_outside;
}

void SurfaceNets::place_vertices(const Index& block, int stride, SurfaceNet& net) {
  const int row = side_;
  const int layer = side_ * side_;
  for (int z = 0; z + 1 < side_; ++z) {
    for (int y = 0; y + 1 < side_; ++y) {
      for (int x = 0; x + 1 < side_; ++x) {
        const float* v = &values_[static_cast<std::size_t>(at(x, y, z))];
        const int inside = (v[0] < 0.0F) + (v[1] < 0.0F) + (v[row] < 0.0F) + (v[row + 1] < 0.0F) + (v[layer] < 0.0F) +
                           (v[layer + 1] < 0.0F) + (v[layer + row] < 0.0F) + (v[layer + row + 1] < 0.0F);
        if (inside == 0 || inside == 8) continue;
        vertex_[static_cast<std::size_t>(at(x, y, z))] = static_cast<std::uint32_t>(net.positions.size());
        place_vertex({x, y, z}, block, stride, net);
      }
    }
  }
}

// The vertex is the same to the last bit in the blocks on both sides of a border: both round once, in the sum of the same two numbers.
void SurfaceNets::place_vertex(const Index& cell, const Index& block, int stride, SurfaceNet& net) const {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  int crossings = 0;
  const std::array<int, 3> steps = {1, side_, side_ * side_};
  const int corner = at(cell[0], cell[1], cell[2]);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t second = (axis + 1) % 3;
    const std::size_t third = (axis + 2) % 3;
    for (int n = 0; n < 4; ++n) {
      const int from = corner + (n & 1) * steps[second] + (n >> 1) * steps[third];
      const float a = values_[static_cast<std::size_t>(from)];
      const float b = values_[static_cast<std::size_t>(from + steps[axis])];
      if ((a < 0.0F) == (b < 0.0F)) continue;
      sum[static_cast<Eigen::Index>(axis)] += a / (a - b);
      sum[static_cast<Eigen::Index>(second)] += static_cast<float>(n & 1);
      sum[static_cast<Eigen::Index>(third)] += static_cast<float>(n >> 1);
      ++crossings;
    }
  }
  const auto first = [&](std::size_t axis) { return block[axis] * kBlock + stride * (cell[axis] - 1); };
  const auto whole = [&](std::size_t axis) { return static_cast<float>(first(axis)); };
  net.positions.emplace_back(Eigen::Vector3f(whole(0), whole(1), whole(2)) +
                             static_cast<float>(stride) * (sum / static_cast<float>(crossings)));
}

// Makes a quad around each edge of the grid that the surface crosses. An edge belongs to the block of its first node.
void SurfaceNets::join_quads(SurfaceNet& net) const {
  const std::array<int, 3> steps = {1, side_, side_ * side_};
  for (int z = 1; z + 1 < side_; ++z) {
    for (int y = 1; y + 1 < side_; ++y) {
      for (int x = 1; x + 1 < side_; ++x) {
        const int node = at(x, y, z);
        const bool is_inside = values_[static_cast<std::size_t>(node)] < 0.0F;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          if ((values_[static_cast<std::size_t>(node + steps[axis])] < 0.0F) == is_inside) continue;
          const int second = steps[(axis + 1) % 3];
          const int third = steps[(axis + 2) % 3];
          const auto vertex = [&](int cell) { return vertex_[static_cast<std::size_t>(cell)]; };
          const std::array<std::uint32_t, 4> quad = {vertex(node - second - third), vertex(node - third), vertex(node),
                                                     vertex(node - second)};
          net.quads.push_back(is_inside ? quad : std::array<std::uint32_t, 4>{quad[3], quad[2], quad[1], quad[0]});
        }
      }
    }
  }
}

}  // namespace hapton
