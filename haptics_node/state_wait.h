#pragma once

#include <cstdint>

#include "link/hub_client.h"
#include "runtime/adaptive_spin.h"
#include "runtime/arrival_forecast.h"
#include "runtime/clock.h"
#include "runtime/spin_trial.h"

namespace hapton {

// Waits for the hub's next message. A sleeping thread needs 10 to 30 us to wake up when a device state arrives. As states arrive at a fixed
// rate, the waiting thread wakes shortly before the next state is due and then polls the socket without sleep, if this helps (SpinTrial).
// Units: ns. RT: yes. Threads: one.
class StateWait {
 public:
  // The thread sleeps for at least this share of each period, so that a loop of real-time priority is never throttled.
  static constexpr double kMinSleepShare = 0.25;

  StateWait(HubClient& hub, const Clock& clock) noexcept : hub_(hub), clock_(clock) {}

  // Sets the longest time to spin for a state; half a period is a limit as well. 0: the thread sleeps until a state arrives.
  void set_longest_spin(std::int64_t longest_ns) noexcept {
    longest_spin_ns_ = longest_ns;
    wake_up_.set_margin_ns(longest_ns / 2);  // starts large: if a state arrives before the wake-up, SpinTrial counts that against spinning
  }

  // As HubClient::receive, but may return up to half a period after deadline_ns.
  bool receive(Datagram& datagram, std::int64_t deadline_ns) noexcept;

  // To be called for each device state that was received.
  void note(const DeviceState& state, std::int64_t arrival_ns) noexcept {
    forecast_.note(state.sample, state.sample_time_ns, arrival_ns, hub_.servo_rate_hz());
  }

  // Total time spent spinning.
  std::int64_t spun_ns() const noexcept { return wake_up_.spun_ns(); }
  // Number of waits that spun, and of those that ended with a message.
  std::uint64_t spins() const noexcept { return spins_; }
  std::uint64_t arrivals() const noexcept { return arrivals_; }

 private:
  bool spin(Datagram& datagram, std::int64_t end_ns) noexcept;

  HubClient& hub_;
  const Clock& clock_;
  std::int64_t longest_spin_ns_ = 0;
  ArrivalForecast forecast_;
  AdaptiveSpin wake_up_{1.0};
  SpinTrial trial_;
  std::uint64_t spins_ = 0;
  std::uint64_t arrivals_ = 0;
};

}  // namespace hapton
