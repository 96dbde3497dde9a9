#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// One side of one triangle: from corner `corner` to the next one.
struct HalfEdge {
  std::uint32_t low = 0;  // the edge's vertices, low < high (equal if the triangle repeats a vertex)
  std::uint32_t high = 0;
  std::uint32_t triangle = 0;
  std::uint8_t corner = 0;
  bool upward = false;  // runs from low to high
};

// All sides of all triangles, grouped by their two vertices (FDH paper, 4.1: "find common edges"). Vertices must be welded. RT:
// set-up only.
class SharedEdges {
 public:
  explicit SharedEdges(std::span<const Triangle> triangles);

  std::size_t size() const { return first_.size() - 1; }
  std::span<const HalfEdge> operator[](std::size_t edge) const { return {sides_.data() + first_[edge], first_[edge + 1] - first_[edge]}; }

  // The edge of side `corner` of a triangle.
  std::uint32_t edge_of(std::uint32_t triangle, int corner) const {
    return edge_of_[3 * std::size_t{triangle} + static_cast<std::size_t>(corner)];
  }

  // The side of the adjacent triangle at this edge, if exactly two triangles share the edge; otherwise nullptr.
  const HalfEdge* adjacent(std::uint32_t triangle, int corner) const;

 private:
  std::vector<HalfEdge> sides_;
  std::vector<std::size_t> first_;
  std::vector<std::uint32_t> edge_of_;
};

}  // namespace hapton
