#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/math/types.h"

namespace hapton {

// Some of the vertices of a mesh in a kd-tree: which are near a point, and which near a segment.
//
// Building takes n log n steps however the points lie, also when all lie in one spot. A query's results do not depend on the order of the
// items. Units and frame: those of the points. RT: set-up only. Threads: one (queries count).
class VertexTree {
 public:
  // A point is tested against so many segments, then left out of find_near_segment: thousands of points and segments in one spot cost
  // time in proportion to their number, not to its square.
  static constexpr std::uint32_t kMostSegments = 256;

  struct Found {
    double squared_distance = 0.0;
    std::uint32_t vertex = 0;
  };

  // items: numbers into points. Pre: points outlive this; finite.
  VertexTree(std::span<const Vec3> points, std::vector<std::uint32_t> items);

  // The nearest items within `reach` of p, at most `most`, nearest first; of equally near ones those of the lowest numbers. `except` is
  // left out.
  void find_nearest(const Vec3& p, std::uint32_t except, double reach, std::size_t most, std::vector<Found>& found) const;

  // All items within `reach` of the segment from a to b, but for those tested kMostSegments times already.
  void find_near_segment(const Vec3& a, const Vec3& b, double reach, std::vector<Found>& found);

 private:
  static constexpr std::uint32_t kLeafSize = 8;
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

  struct Node {
    Vec3 low, high;
    std::uint32_t first = 0;  // items
    std::uint32_t last = 0;
    std::uint32_t right = kNone;  // the left child follows its parent; none: a leaf
    std::uint32_t open = 0;       // items that may still be tested against segments
  };

  std::uint32_t build(std::uint32_t first, std::uint32_t last);

  std::span<const Vec3> points_;
  std::vector<std::uint32_t> items_;
  std::vector<std::uint32_t> tested_;  // how often, by place in items_
  std::vector<Node> nodes_;
};

}  // namespace hapton
