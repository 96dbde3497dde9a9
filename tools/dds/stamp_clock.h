#pragma once

#include <cstdint>
#include <limits>

namespace hapton::dds {

// Turns the hub's sample times into times of day that strictly increase. On the hub's own host both clocks are one. From another host, the
// state that came fastest within the last 10 to 20 s is taken to have needed no time, so a stamp is late by the fastest way from the hub.
// Units: ns; times of day since 1970. RT: yes. Threads: one.
class StampClock {
 public:
  static constexpr std::int64_t kWindowNs = 10'000'000'000;  // in which the shortest delay of a datagram is searched for; a free choice
  // The time of day is set back by more: stamps follow it. Otherwise they wait.
  static constexpr std::int64_t kSetBackNs = 1'000'000'000;

  explicit StampClock(bool has_hub_clock) noexcept : has_hub_clock_(has_hub_clock) {}

  // Another session of the hub, with a clock of its own perhaps. Stamps go on increasing.
  void reset() noexcept;

  // Of a state taken at sample_ns on the hub's clock and received at received_ns on ours, where the time of day is day_offset_ns later.
  std::int64_t stamp_ns(std::int64_t sample_ns, std::int64_t received_ns, std::int64_t day_offset_ns) noexcept;

 private:
  static constexpr std::int64_t kNone = std::numeric_limits<std::int64_t>::max();

  bool has_hub_clock_;
  std::int64_t window_start_ns_ = kNone;
  std::int64_t least_ns_ = kNone;         // received - sample, of this window
  std::int64_t least_before_ns_ = kNone;  // and of the one before
  std::int64_t last_ns_ = std::numeric_limits<std::int64_t>::min();
};

}  // namespace hapton::dds
