#include "bench/measure/step_times.h"

#include <algorithm>
#include <cmath>

namespace hapton {

TimeSpread spread_of_times(std::vector<double> ns) {
  TimeSpread spread;
  spread.count = ns.size();
  if (ns.empty()) return spread;
  std::sort(ns.begin(), ns.end());
  const auto rank = [&](double share) {
    const double at = std::ceil(share * static_cast<double>(ns.size())) - 1.0;
    return ns[static_cast<std::size_t>(std::max(0.0, at))];
  };
  spread.p50_ns = rank(0.50);
  spread.p90_ns = rank(0.90);
  spread.p99_ns = rank(0.99);
  spread.p99_9_ns = rank(0.999);
  spread.worst_ns = ns.back();
  return spread;
}

std::vector<double> LeastTimes::only(const std::vector<std::uint8_t>& keep) const {
  std::vector<double> kept;
  for (std::size_t i = 0; i < ns_.size(); ++i) {
    if (keep[i] != 0) kept.push_back(ns_[i]);
  }
  return kept;
}

}  // namespace hapton
