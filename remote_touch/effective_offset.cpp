#include "remote_touch/effective_offset.h"

#include <algorithm>
#include <cstdint>
#include <limits>

namespace hapton {

EffectiveOffset find_effective_offset(const std::vector<Vec3>& signal, const std::vector<Vec3>& reference, double period_s,
                                      std::size_t max_delay, double step_cost, double min_norm) {
  const std::size_t count = std::min(signal.size(), reference.size());
  if (count == 0) return {};
  const std::size_t width = max_delay + 1;
  // Before its first sample, the reference has the value of that sample.
  const auto difference = [&](std::size_t i, std::size_t delay) { return (signal[i] - reference[i >= delay ? i - delay : 0]).norm(); };
  std::vector<double> cost(width);
  std::vector<double> next_cost(width);
  std::vector<std::int8_t> change(count * width, 0);  // by how much `delay` differs from that of the sample before: -1, 0 or 1
  for (std::size_t delay = 0; delay < width; ++delay) cost[delay] = difference(0, delay);
  for (std::size_t i = 1; i < count; ++i) {
    std::int8_t* const change_row = change.data() + i * width;
    for (std::size_t delay = 0; delay < width; ++delay) {
      double best = cost[delay];
      if (delay > 0 && cost[delay - 1] + step_cost < best) {
        best = cost[delay - 1] + step_cost;
        change_row[delay] = 1;
      }
      if (delay + 1 < width && cost[delay + 1] + step_cost < best) {
        best = cost[delay + 1] + step_cost;
        change_row[delay] = -1;
      }
      next_cost[delay] = best + difference(i, delay);
    }
    cost.swap(next_cost);
  }
  std::size_t delay = static_cast<std::size_t>(std::min_element(cost.begin(), cost.end()) - cost.begin());
  EffectiveOffset offset;
  std::size_t compared = 0;
  for (std::size_t i = count; i-- > 0;) {
    if (signal[i].norm() > min_norm || reference[i].norm() > min_norm) {
      ++compared;
      offset.time_s += period_s * static_cast<double>(delay);
      offset.value += difference(i, delay);
    }
    delay -= static_cast<std::size_t>(static_cast<std::ptrdiff_t>(change[i * width + delay]));
  }
  if (compared == 0) return {};
  return {offset.time_s / static_cast<double>(compared), offset.value / static_cast<double>(compared)};
}

}  // namespace hapton
