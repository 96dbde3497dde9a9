#include "link/clock_offset.h"

#include <cmath>

namespace hapton {

std::int64_t ClockOffset::error_bound_ns(std::int64_t now_ns) const noexcept {
  const double age_ns = std::abs(static_cast<double>(now_ns) - static_cast<double>(exchange_ns_));
  return error_bound_ns_ + static_cast<std::int64_t>(kDriftShare * age_ns);
}

void ClockOffset::add(const Exchange& exchange) noexcept {
  std::int64_t upper_ns = 0;  // the offset is at most t2 - t1
  std::int64_t lower_ns = 0;  // and at least t3 - t4
  std::int64_t spread_ns = 0;
  const bool overflows = __builtin_sub_overflow(exchange.t2_ns, exchange.t1_ns, &upper_ns) ||
                         __builtin_sub_overflow(exchange.t3_ns, exchange.t4_ns, &lower_ns) ||
                         __builtin_sub_overflow(upper_ns, lower_ns, &spread_ns);
  if (overflows || spread_ns < 0 || exchange.t4_ns < exchange.t1_ns || exchange.t3_ns < exchange.t2_ns) return;
  const std::int64_t bound_ns = spread_ns / 2 + 1;
  if (is_known_ && bound_ns > error_bound_ns(exchange.t4_ns)) return;
  is_known_ = true;
  offset_ns_ = lower_ns + spread_ns / 2;
  error_bound_ns_ = bound_ns;
  exchange_ns_ = exchange.t4_ns;
}

}  // namespace hapton
