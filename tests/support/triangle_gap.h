#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/geometry/triangle_distance.h"

namespace hapton {

// The distance between two triangles that do not intersect: the least of corner to triangle and of edge to edge. If an edge of one goes
// through the inside of the other, the result is above zero, although they intersect.
inline double triangle_gap(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b) {
  double least = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    least = std::min(least, triangle_distance_squared(a[k], b[0], b[1], b[2]));
    least = std::min(least, triangle_distance_squared(b[k], a[0], a[1], a[2]));
    for (int j = 0; j < 3; ++j) {
      least = std::min(least, detail::segment_segment_distance_squared(of3(a[k]), of3(Vec3(a[(k + 1) % 3] - a[k])), of3(b[j]),
                                                                       of3(Vec3(b[(j + 1) % 3] - b[j]))));
    }
  }
  return std::sqrt(least);
}

}  // namespace hapton
