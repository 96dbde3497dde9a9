#pragma once

#include <cstdint>
#include <limits>

namespace hapton::dds {

// Turns the hub's sample times into times of day, which strictly increase unless the time of day is set back by kSetBackNs. On the hub's
// host both use the same clock. On another host the fastest state of the last 10 to 20 s is taken to have needed no time, so stamps are
// late by the shortest delay from the hub. Units: ns; times of day since 1970. RT: yes. Threads: one.
class StampClock {
 public:
  static constexpr std::int64_t kWindowNs = 10'000'000'000;  // the shortest delay of a datagram is that of a window; a free choice
  // If the time of day is set back by this or more, stamps follow it; if by less, they advance by 1 ns until it has caught up.
  static constexpr std::int64_t kSetBackNs = 1'000'000'000;

  explicit StampClock(bool has_hub_clock) noexcept : has_hub_clock_(has_hub_clock) {}

  // For a new session of the hub, which may have another clock: forgets the delays. Stamps still increase.
  void reset() noexcept;

  // The stamp of a state sampled at sample_ns (hub's clock), received at received_ns (our clock). day_offset_ns: time of day - our clock.
  std::int64_t stamp_ns(std::int64_t sample_ns, std::int64_t received_ns, std::int64_t day_offset_ns) noexcept;

 private:
  static constexpr std::int64_t kNone = std::numeric_limits<std::int64_t>::max();

  bool has_hub_clock_;
  std::int64_t window_start_ns_ = kNone;
  std::int64_t least_offset_ns_ = kNone;           // the least received_ns - sample_ns in this window
  std::int64_t previous_least_offset_ns_ = kNone;  // the least in the window before
  std::int64_t last_stamp_ns_ = std::numeric_limits<std::int64_t>::min();
};

}  // namespace hapton::dds
