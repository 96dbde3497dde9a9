// Component safety alone: a governor limits a force of 50 N.
#include <cstdio>

#include "safety/safety_governor.h"

int main() {
  using namespace hapton;
  SafetyGovernor governor({.max_force_n = 3.0, .max_slew_n_per_s = 3000.0});
  double most_n = 0.0;
  for (std::uint64_t sample = 1; sample <= 1000; ++sample) {
    const std::int64_t now_ns = static_cast<std::int64_t>(sample) * 1'000'000;
    governor.observe({.time_ns = now_ns}, DeviceStatus::ready);
    const WrenchCommand wanted{.wrench = {.force_n = {0, 0, 50.0}}, .sample_time_ns = now_ns};
    most_n = std::max(most_n, governor.step(wanted, now_ns).force_n.norm());
  }
  std::printf("%.3f N\n", most_n);
  return most_n > 0.0 && most_n <= 3.0 ? 0 : 1;
}
