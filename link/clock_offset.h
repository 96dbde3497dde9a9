#pragma once

#include <cstdint>

namespace hapton {

// How far the clock of another host is ahead of ours, from datagrams that go there and back, with an error bound.
//
// A request leaves us at t1 on our clock and arrives at t2 on their clock; the reply leaves at t3 on theirs and arrives at t4 on ours.
// However long each direction took, the offset is between t3 - t4 and t2 - t1. The middle is the estimate, and half the time on the wire is
// its error bound. The shortest exchange is the most accurate. The bound of an exchange grows by kDriftShare of its age, the fastest
// relative drift of two clocks that adjtime(3) slews in opposite directions. Source: D. Mills, RFC 5905 (NTP), section 10, the clock
// filter. Units: ns. RT: yes. Threads: one.
class ClockOffset {
 public:
  static constexpr double kDriftShare = 1e-3;  // 500 ppm each, the most that adjtime(3) slews; chrony may slew faster

  struct Exchange {
    std::int64_t t1_ns = 0;  // ours: leaves
    std::int64_t t2_ns = 0;  // theirs: arrives
    std::int64_t t3_ns = 0;  // theirs: the reply leaves
    std::int64_t t4_ns = 0;  // ours: the reply arrives
  };

  // Adds an exchange; one with impossible times (or whose difference overflows) is ignored.
  void add(const Exchange& exchange) noexcept;
  // Call when another process replies, because it may have another clock.
  void forget() noexcept { *this = ClockOffset(); }

  bool is_known() const noexcept { return is_known_; }
  // Their clock minus ours. Pre: is_known().
  std::int64_t offset_ns() const noexcept { return offset_ns_; }
  // Largest distance of the true offset from offset_ns() at the time now_ns of our clock.
  std::int64_t error_bound_ns(std::int64_t now_ns) const noexcept;

 private:
  bool is_known_ = false;
  std::int64_t offset_ns_ = 0;
  std::int64_t error_bound_ns_ = 0;
  std::int64_t exchange_ns_ = 0;  // when the reply of that exchange arrived, our clock
};

}  // namespace hapton
