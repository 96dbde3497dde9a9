#pragma once

#include <cstddef>
#include <vector>

namespace hapton {

// Time and error of a method: smaller is better for both. Any units, the same for all points that are compared.
struct ParetoPoint {
  double time = 0.0;
  double error = 0.0;
};

// The points that no other one dominates: none is at least as good in both and better in one. Their indices in `points`, by increasing
// time. Of equal points only the first is listed. A point that is not finite is never on the front.
std::vector<std::size_t> find_pareto_front(const std::vector<ParetoPoint>& points);

}  // namespace hapton
