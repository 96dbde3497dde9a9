#include "tools/dds/stamp_clock.h"

#include <algorithm>

namespace hapton::dds {

void StampClock::reset() noexcept {
  window_start_ns_ = kNone;
  least_offset_ns_ = kNone;
  previous_least_offset_ns_ = kNone;
}

std::int64_t StampClock::stamp_ns(std::int64_t sample_ns, std::int64_t received_ns, std::int64_t day_offset_ns) noexcept {
  if (window_start_ns_ == kNone) window_start_ns_ = received_ns;
  if (received_ns - window_start_ns_ >= kWindowNs) {
    previous_least_offset_ns_ = least_offset_ns_;
    least_offset_ns_ = kNone;
    window_start_ns_ = received_ns;
  }
  least_offset_ns_ = std::min(least_offset_ns_, received_ns - sample_ns);
  const std::int64_t offset_ns = has_hub_clock_ ? 0 : std::min(least_offset_ns_, previous_least_offset_ns_);
  std::int64_t stamp = sample_ns + offset_ns + day_offset_ns;
  if (stamp <= last_stamp_ns_ && stamp > last_stamp_ns_ - kSetBackNs) stamp = last_stamp_ns_ + 1;
  last_stamp_ns_ = stamp;
  return stamp;
}

}  // namespace hapton::dds
