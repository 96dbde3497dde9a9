#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/median_tree.h"
#include "core/math/types.h"

namespace hapton {

// A kd-tree of some of the vertices of a mesh: finds those near a point or a segment.
//
// Construction takes n log n steps for any input, also if all points are equal. The result of a query does not depend on the order of the
// items. Units and frame: those of the points. RT: set-up only. Threads: one (find_near_segment changes counts).
class VertexTree {
 public:
  // Each point is tested against this many segments, and then ignored by find_near_segment, so that thousands of points and segments in one
  // place cost time in proportion to their number, not to its square.
  static constexpr std::uint32_t kMaxSegments = 256;

  struct NearVertex {
    double squared_distance = 0.0;
    std::uint32_t vertex = 0;
  };

  // items: indices into points. Pre: points outlive this and are finite.
  VertexTree(std::span<const Vec3> points, std::vector<std::uint32_t> items);

  // The nearest items within `radius` of p, `most` at most, the nearest first and equally near ones by number. `except` is left out.
  void find_nearest(const Vec3& p, std::uint32_t except, double radius, std::size_t max_count, std::vector<NearVertex>& found) const;

  // All items within `radius` of the segment from a to b, by number, except those tested kMaxSegments times already.
  void find_near_segment(const Vec3& a, const Vec3& b, double radius, std::vector<NearVertex>& found);

 private:
  static constexpr std::uint32_t kLeafSize = 8;

  std::span<const Vec3> points_;
  std::vector<std::uint32_t> items_;
  std::vector<std::uint32_t> test_counts_;  // test count of each item, by position in items_
  MedianTree tree_;                         // `open_items` in its nodes: items that may still be tested against segments
};

}  // namespace hapton
