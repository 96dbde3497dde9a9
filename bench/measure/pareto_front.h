#pragma once

#include <cstddef>
#include <vector>

namespace hapton {

// What a method costs and how wrong it is: smaller is better in both.
struct ParetoPoint {
  double time = 0.0;
  double error = 0.0;
};

// The points that no other one beats: none is at least as good in both and better in one. Their places in `points`, by rising time. Of
// equal points the first stands for all. A point that is not finite is never on the front.
std::vector<std::size_t> find_pareto_front(const std::vector<ParetoPoint>& points);

}  // namespace hapton
