#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>

namespace hapton {

// When the next sample of a periodic sender may arrive at the earliest: the time of the last sample, plus a period, plus the shortest delay
// of the last kDelays to 2 kDelays samples. The two clocks may differ by any offset, which is part of that delay (minimum filter, as for
// clock offsets: Mills 1991). Units: ns. RT: yes. Threads: one.
class ArrivalForecast {
 public:
  static constexpr std::uint32_t kDelays = 32;

  // sample: its number; sample_ns: its time by the sender's clock; arrival_ns: by this one's.
  void note(std::uint64_t sample, std::int64_t sample_ns, std::int64_t arrival_ns) noexcept {
    is_in_sequence_ = sample == sample_ + 1;
    sample_ = sample;
    sample_ns_ = sample_ns;
    shortest_ns_ = std::min(shortest_ns_, arrival_ns - sample_ns);
    if (++delays_ < kDelays) return;
    shortest_before_ns_ = shortest_ns_;
    shortest_ns_ = kNone;
    delays_ = 0;
  }

  // By this clock. Empty if not every sample is sent, or too few are known.
  std::optional<std::int64_t> find_next_ns(double rate_hz) const noexcept {
    if (!is_in_sequence_ || shortest_before_ns_ == kNone || !(rate_hz > 0.0)) return std::nullopt;
    return sample_ns_ + static_cast<std::int64_t>(1e9 / rate_hz) + std::min(shortest_before_ns_, shortest_ns_);
  }

 private:
  static constexpr std::int64_t kNone = std::numeric_limits<std::int64_t>::max();

  std::uint64_t sample_ = 0;
  std::int64_t sample_ns_ = 0;
  std::int64_t shortest_ns_ = kNone;         // delay of this block of samples
  std::int64_t shortest_before_ns_ = kNone;  // ... of the one before
  std::uint32_t delays_ = 0;                 // of this block
  bool is_in_sequence_ = false;
};

}  // namespace hapton
