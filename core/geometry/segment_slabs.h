#pragma once

#include <cmath>

#include "core/math/types.h"

namespace hapton {

// A segment, prepared for tests against many axis-aligned boxes by the slab test. Units and frame: those of the points. RT: yes.
class SegmentSlabs {
 public:
  SegmentSlabs(const Vec3& a, const Vec3& b) : start_(a) {
    for (int axis = 0; axis < 3; ++axis) {
      const double along = b[axis] - a[axis];
      inverse_[axis] = std::fabs(along) > 1e-300 ? 1.0 / along : 1e300;  // no motion along the axis: inside the slab or far outside
    }
  }

  // Whether the segment meets the box, up to rounding.
  bool meets(const Vec3& low, const Vec3& high) const {
    const Vec3 to_low = (low - start_).cwiseProduct(inverse_);
    const Vec3 to_high = (high - start_).cwiseProduct(inverse_);
    return to_low.cwiseMin(to_high).cwiseMax(0.0).maxCoeff() <= to_low.cwiseMax(to_high).cwiseMin(1.0).minCoeff();
  }

 private:
  Vec3 start_;
  Vec3 inverse_;  // 1 / displacement from start to end, by axis
};

}  // namespace hapton
