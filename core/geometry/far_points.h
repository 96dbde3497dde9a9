#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/geometry/median_tree.h"
#include "core/math/types.h"

namespace hapton {

// A tree of boxes around points that tells how far the farthest point lies in a direction.
//
// Construction takes n log n steps for any input. A query looks only at boxes that reach farther than the farthest point so far: on a
// curved surface, those near it. Frame and unit: those of the points. RT: set-up only. Threads: one (queries change a count).
class FarPoints {
 public:
  // By how much the result of a query may be too small, as a share of the extent of all points: far more than rounding, so that points that
  // are equally far are not looked at one by one.
  static constexpr double kRelativeError = 0x1p-40;

  // Pre: all points are finite.
  explicit FarPoints(std::vector<Vec3> points);

  // The largest direction . (point - from) of all points, or `least` if that is larger; the result may be too small by up to kRelativeError
  // times the extent. Pre: the direction is a unit vector.
  double find_farthest(const Vec3& direction, const Vec3& from, double least);
  // The longest side of the box around all points.
  double extent() const noexcept { return extent_; }
  // The number of points and boxes that were looked at so far.
  std::size_t comparisons() const noexcept { return comparisons_; }

 private:
  static constexpr std::uint32_t kLeafSize = 8;

  struct Box {
    Vec3 centre, half;
  };

  std::vector<Vec3> points_;
  MedianTree tree_;
  std::vector<Box> boxes_;  // by node of the tree
  double extent_ = 0.0;
  std::size_t comparisons_ = 0;
};

}  // namespace hapton
