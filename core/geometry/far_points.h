#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/geometry/median_tree.h"
#include "core/math/types.h"

namespace hapton {

// Points in a tree of boxes: how far the farthest of them lies in a direction.
//
// Construction takes n log n steps for any input. A query looks at the boxes that reach farther than what it has: of points on a curved
// surface those around the farthest. Frame and unit: those of the points. RT: set-up only. Threads: one (queries count).
class FarPoints {
 public:
  // What a query may miss, as a share of the extent of all points: far more than rounding, so that equally far points are not looked at
  // one by one.
  static constexpr double kAgree = 0x1p-40;

  // Pre: finite.
  explicit FarPoints(std::vector<Vec3> points);

  // The largest direction . (point - from) of all points, or `least` if that is larger; either up to kAgree of the extent. Pre: the
  // direction is a unit vector.
  double find_farthest(const Vec3& direction, const Vec3& from, double least);
  // The longest side of the box around all points.
  double extent() const noexcept { return extent_; }
  // Points and boxes that were looked at so far.
  std::size_t compared() const noexcept { return compared_; }

 private:
  static constexpr std::uint32_t kLeafSize = 8;

  struct Box {
    Vec3 centre, half;
  };

  std::vector<Vec3> points_;
  MedianTree tree_;
  std::vector<Box> boxes_;  // of its nodes
  double extent_ = 0.0;
  std::size_t compared_ = 0;
};

}  // namespace hapton
