#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>

namespace hapton {

// The earliest time at which the next sample of a periodic sender may arrive: its last tick, plus a period, plus the shortest delay of the
// newest samples (at least kDelays of them, fewer than 2 kDelays). A sample is taken at its tick or later; one that is late by less than
// half a period does not move the ticks, unless the kDelays samples before it were all late. The two clocks may differ by any offset: it is
// part of that delay (minimum filter, as for clock offsets: Mills 1991). Units: ns. RT: yes. Threads: one.
class ArrivalForecast {
 public:
  static constexpr std::uint32_t kDelays = 32;

  // sample: its number. sample_ns: its time by the sender's clock. arrival_ns: its arrival by the receiver's clock. rate_hz: rate of the
  // samples; 0: unknown. Pre: the values are such as a decoder accepts (link/codec.h: kMaxWireTimeNs).
  void note(std::uint64_t sample, std::int64_t sample_ns, std::int64_t arrival_ns, double rate_hz) noexcept {
    period_ns_ = rate_hz > 0.0 ? static_cast<std::int64_t>(1e9 / rate_hz) : 0;
    is_in_sequence_ = sample == sample_ + 1;
    sample_ = sample;
    const std::int64_t late_ns = sample_ns - (tick_ns_ + period_ns_);
    const bool is_late = is_in_sequence_ && late_ns > 0 && late_ns < period_ns_ - late_ns && late_samples_ < kDelays;
    late_samples_ = is_late ? late_samples_ + 1 : 0;
    tick_ns_ = is_late ? tick_ns_ + period_ns_ : sample_ns;
    shortest_ns_ = std::min(shortest_ns_, arrival_ns - sample_ns);
    if (++delay_count_ < kDelays) return;
    shortest_before_ns_ = shortest_ns_;
    shortest_ns_ = kNone;
    delay_count_ = 0;
  }

  // The forecast, receiver's clock. None: the newest sample does not follow the one before, the rate is unknown, or too few have arrived.
  std::optional<std::int64_t> find_next_ns() const noexcept {
    if (!is_in_sequence_ || shortest_before_ns_ == kNone || period_ns_ == 0) return std::nullopt;
    return tick_ns_ + period_ns_ + std::min(shortest_before_ns_, shortest_ns_);
  }
  std::int64_t period_ns() const noexcept { return period_ns_; }

 private:
  static constexpr std::int64_t kNone = std::numeric_limits<std::int64_t>::max();

  std::uint64_t sample_ = 0;
  std::int64_t tick_ns_ = 0;
  std::int64_t period_ns_ = 0;
  std::int64_t shortest_ns_ = kNone;         // shortest delay in this block of kDelays samples
  std::int64_t shortest_before_ns_ = kNone;  // the same, in the block before
  std::uint32_t delay_count_ = 0;            // delays in this block
  std::uint32_t late_samples_ = 0;           // late samples in a row
  bool is_in_sequence_ = false;
};

}  // namespace hapton
