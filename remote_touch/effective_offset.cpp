#include "remote_touch/effective_offset.h"

#include <algorithm>
#include <cstdint>
#include <limits>

namespace hapton {

EffectiveOffset find_effective_offset(const std::vector<Vec3>& signal, const std::vector<Vec3>& reference, double period_s,
                                      std::size_t most_late, double step_cost, double least) {
  const std::size_t count = std::min(signal.size(), reference.size());
  if (count == 0) return {};
  const std::size_t width = most_late + 1;
  // Before its first sample, the reference has the value of that sample.
  const auto difference = [&](std::size_t i, std::size_t late) { return (signal[i] - reference[i >= late ? i - late : 0]).norm(); };
  std::vector<double> cost(width);
  std::vector<double> next(width);
  std::vector<std::int8_t> change(count * width, 0);  // by how much `late` differs from that of the sample before: -1, 0 or 1
  for (std::size_t late = 0; late < width; ++late) cost[late] = difference(0, late);
  for (std::size_t i = 1; i < count; ++i) {
    std::int8_t* const into = change.data() + i * width;
    for (std::size_t late = 0; late < width; ++late) {
      double best = cost[late];
      if (late > 0 && cost[late - 1] + step_cost < best) {
        best = cost[late - 1] + step_cost;
        into[late] = 1;
      }
      if (late + 1 < width && cost[late + 1] + step_cost < best) {
        best = cost[late + 1] + step_cost;
        into[late] = -1;
      }
      next[late] = best + difference(i, late);
    }
    cost.swap(next);
  }
  std::size_t late = static_cast<std::size_t>(std::min_element(cost.begin(), cost.end()) - cost.begin());
  EffectiveOffset offset;
  std::size_t counted = 0;
  for (std::size_t i = count; i-- > 0;) {
    if (signal[i].norm() > least || reference[i].norm() > least) {
      ++counted;
      offset.time_s += period_s * static_cast<double>(late);
      offset.value += difference(i, late);
    }
    late -= static_cast<std::size_t>(static_cast<std::ptrdiff_t>(change[i * width + late]));
  }
  if (counted == 0) return {};
  return {offset.time_s / static_cast<double>(counted), offset.value / static_cast<double>(counted)};
}

}  // namespace hapton
