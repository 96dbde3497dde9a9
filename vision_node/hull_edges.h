#pragma once

#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "core/collision/fdh_directions.h"

namespace hapton {

// The points p between two parallel planes: low <= axis . p <= high.
struct HullSlab {
  Vec3 axis;  // normal of the planes, of any length above zero
  double low = 0.0;
  double high = 0.0;
};

using HullEdge = std::pair<Vec3, Vec3>;

// The edges of the polyhedron that is inside all slabs, each once. Empty: it has no interior, or there are fewer than three slabs.
// Pre: the first three axes are x, y and z. RT: no.
std::vector<HullEdge> find_hull_edges(const std::vector<HullSlab>& slabs);

// The edges of the hull, after it has been grown in every direction by that share of its diagonal: flat hulls have edges then, too.
template <int K>
std::vector<HullEdge> find_hull_edges(const FdhHull<K>& hull, double grow_share = 1e-6) {
  const double diagonal =
      std::sqrt((hull.high[0] - hull.low[0]) * (hull.high[0] - hull.low[0]) + (hull.high[1] - hull.low[1]) * (hull.high[1] - hull.low[1]) +
                (hull.high[2] - hull.low[2]) * (hull.high[2] - hull.low[2]));
  std::vector<HullSlab> slabs;
  for (int i = 0; i < K / 2; ++i) {
    const auto& axis = FdhDirections<K>::kAxis[i];
    const double grow = grow_share * diagonal * std::sqrt(static_cast<double>(FdhDirections<K>::length_squared(i)));
    slabs.push_back({Vec3(axis[0], axis[1], axis[2]), hull.low[i] - grow, hull.high[i] + grow});
  }
  return find_hull_edges(slabs);
}

}  // namespace hapton
