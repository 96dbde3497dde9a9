// Component safety alone: a governor limits a force of 50 N.
#include <cstdio>

#include "safety/safety_governor.h"

int main() {
  using namespace hapton;
  SafetyGovernor governor({.max_force_n = 3.0, .max_slew_n_per_s = 3000.0});
  double largest_n = 0.0;
  for (std::uint64_t sample = 1; sample <= 1000; ++sample) {
    const std::int64_t now_ns = static_cast<std::int64_t>(sample) * 1'000'000;
    governor.observe({.time_ns = now_ns}, DeviceStatus::ready);
    const WrenchCommand requested{.wrench = {.force_n = {0, 0, 50.0}}, .sample_time_ns = now_ns};
    largest_n = std::max(largest_n, governor.step(requested, now_ns).force_n.norm());
  }
  std::printf("%.3f N\n", largest_n);
  return largest_n > 0.0 && largest_n <= 3.0 ? 0 : 1;
}
