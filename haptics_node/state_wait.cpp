#include "haptics_node/state_wait.h"

#include <algorithm>

namespace hapton {

bool StateWait::receive(Datagram& datagram, std::int64_t deadline_ns) noexcept {
  const auto due_ns = longest_spin_ns_ > 0 ? forecast_.find_next_ns() : std::nullopt;
  if (!due_ns) return hub_.receive(datagram, deadline_ns);
  const std::int64_t period_ns = forecast_.period_ns();
  const std::int64_t longest_ns = std::min(longest_spin_ns_, period_ns / 2);
  // Wakes at most longest_ns / 2 before the state is due, and at least an eighth: arrival times in the forecast include late wake-ups.
  const std::int64_t wake_ns = *due_ns - std::clamp(wake_up_.margin_ns(period_ns), longest_ns / 8, longest_ns / 2);
  const auto least_sleep_ns = static_cast<std::int64_t>(kMinSleepShare * static_cast<double>(period_ns));
  if (wake_ns - clock_.now_ns() < least_sleep_ns || wake_ns >= deadline_ns || !trial_.may_spin()) {
    return hub_.receive(datagram, deadline_ns);
  }
  if (hub_.receive(datagram, wake_ns)) {
    trial_.note(false);
    wake_up_.note_wake_up(period_ns);
    return true;
  }
  wake_up_.note_wake_up(clock_.now_ns() - wake_ns);
  return spin(datagram, wake_ns + longest_ns) || hub_.receive(datagram, deadline_ns);
}

bool StateWait::spin(Datagram& datagram, std::int64_t end_ns) noexcept {
  const std::int64_t begin_ns = clock_.now_ns();
  std::int64_t now_ns = begin_ns;
  bool has_arrived = false;
  for (; !has_arrived && now_ns < end_ns; now_ns = clock_.now_ns()) has_arrived = hub_.receive(datagram, 0);
  wake_up_.note_spun(now_ns - begin_ns);
  trial_.note(has_arrived);
  ++spins_;
  arrivals_ += has_arrived ? 1 : 0;
  return has_arrived;
}

}  // namespace hapton
