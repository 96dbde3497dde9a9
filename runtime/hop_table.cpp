#include "runtime/hop_table.h"

#include <fmt/core.h>

#include "runtime/report.h"

namespace hapton {

HopRow make_hop_row(const LatencyHop& hop) {
  const auto us = [&](double share) { return 1e-3 * hop.histogram.quantile_ns(share); };
  return {.name = hop.name,
          .n = hop.histogram.count(),
          .p50_us = us(0.5),
          .p90_us = us(0.9),
          .p99_us = us(0.99),
          .p99_9_us = us(0.999),
          .max_us = 1e-3 * static_cast<double>(hop.histogram.max_ns())};
}

std::string make_hop_table(const std::vector<HopRow>& hops) {
  std::string lines;
  for (const HopRow& hop : hops) {
    if (hop.n == 0) continue;
    lines += fmt::format("{:<18} {:>8} {:>9.2f} {:>9.2f} {:>9.2f} {:>9.2f} {:>9.2f}\n", hop.name, hop.n, hop.p50_us, hop.p90_us, hop.p99_us,
                         hop.p99_9_us, hop.max_us);
  }
  if (lines.empty()) return lines;
  return fmt::format("{:<18} {:>8} {:>9} {:>9} {:>9} {:>9} {:>9}\n", "us", "n", "p50", "p90", "p99", "p99.9", "max") + lines;
}

}  // namespace hapton
