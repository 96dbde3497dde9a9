#include "runtime/bare_timer.h"

#include <cmath>
#include <thread>

#include "runtime/start_thread.h"

namespace hapton {

double BareTimer::missed_share() const noexcept {
  const std::uint64_t all = ticks + missed;
  return all == 0 ? 0.0 : static_cast<double>(missed) / static_cast<double>(all);
}

void BareTimer::merge(const BareTimer& other) noexcept {
  ticks += other.ticks;
  missed += other.missed;
  lateness.merge(other.lateness);
}

BareTimer run_bare_timer(Clock& clock, double rate_hz, double seconds) noexcept {
  BareTimer timer;
  timer.rate_hz = rate_hz;
  const std::int64_t period_ns = std::llround(1e9 / rate_hz);
  std::int64_t tick_ns = clock.now_ns() + period_ns;
  const std::int64_t end_ns = tick_ns + std::llround(1e9 * seconds);
  while (tick_ns < end_ns) {
    clock.sleep_until_ns(tick_ns);
    const std::int64_t late_ns = clock.now_ns() - tick_ns;
    timer.lateness.record(late_ns);
    ++timer.ticks;
    timer.missed += static_cast<std::uint64_t>(late_ns / period_ns);
    tick_ns += (1 + late_ns / period_ns) * period_ns;
  }
  return timer;
}

Result<BareTimer> measure_bare_timer(const RealtimeSettings& settings, double rate_hz, double seconds) {
  Result<BareTimer> timer;
  start_thread([&] {
    SteadyClock clock;
    const auto entered = enter_realtime(settings);
    timer = entered ? Result<BareTimer>(run_bare_timer(clock, rate_hz, seconds)) : tl::unexpected(entered.error());
  }).join();
  return timer;
}

}  // namespace hapton
