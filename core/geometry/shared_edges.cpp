#include "core/geometry/shared_edges.h"

#include <algorithm>

namespace hapton {

SharedEdges::SharedEdges(std::span<const Triangle> triangles) : sides_(3 * triangles.size()), edge_of_(3 * triangles.size()) {
  std::uint32_t largest = 0;
  for (const Triangle& t : triangles) largest = std::max({largest, t[0], t[1], t[2]});
  // Sorts the sides by their lower vertex with a counting sort, then those of each lower vertex, which are few, by the higher one.
  std::vector<std::uint32_t> next(std::size_t{largest} + 2, 0);
  for (const Triangle& t : triangles) {
    for (int k = 0; k < 3; ++k) ++next[std::min(t[k], t[(k + 1) % 3]) + 1];
  }
  for (std::size_t v = 1; v < next.size(); ++v) next[v] += next[v - 1];
  const std::vector<std::uint32_t> bucket = next;
  for (std::uint32_t i = 0; i < triangles.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = triangles[i][k];
      const std::uint32_t b = triangles[i][(k + 1) % 3];
      sides_[next[std::min(a, b)]++] = {std::min(a, b), std::max(a, b), i, static_cast<std::uint8_t>(k), a < b};
    }
  }
  for (std::size_t v = 0; v + 1 < bucket.size(); ++v) {
    std::sort(sides_.begin() + bucket[v], sides_.begin() + bucket[v + 1], [](const HalfEdge& a, const HalfEdge& b) {
      return a.high != b.high ? a.high < b.high : a.triangle != b.triangle ? a.triangle < b.triangle : a.corner < b.corner;
    });
  }
  for (std::size_t i = 0; i < sides_.size(); ++i) {
    const HalfEdge& side = sides_[i];
    if (i == 0 || side.low != sides_[i - 1].low || side.high != sides_[i - 1].high) first_.push_back(i);
    edge_of_[3 * std::size_t{side.triangle} + side.corner] = static_cast<std::uint32_t>(first_.size() - 1);
  }
  first_.push_back(sides_.size());
}

const HalfEdge* SharedEdges::adjacent(std::uint32_t triangle, int corner) const {
  const std::uint32_t edge = edge_of(triangle, corner);
  const std::size_t first = first_[edge];
  if (first_[edge + 1] - first != 2) return nullptr;
  const HalfEdge& one = sides_[first];
  const HalfEdge& other = sides_[first + 1];
  if (one.triangle == other.triangle) return nullptr;
  return one.triangle == triangle ? &other : &one;
}

}  // namespace hapton
