#pragma once

#include <cstdint>
#include <utility>

namespace hapton {

// Decides which frames acknowledge their state to the hub: the first one with a state, and, until a newer state comes, one more in each
// kRepeatPeriodNs. If an acknowledgement is lost, the hub sends no other state for a tenth of a second; without repeats, a picture that is
// drawn all the time would stand still for as long. Times: any one monotonic clock, ns.
class StateAcks {
 public:
  // As long as two frames at 60 Hz: on a usual network the next state of a hand that moves is there by then.
  static constexpr std::int64_t kRepeatPeriodNs = 33'000'000;

  enum class Kind : std::uint8_t { none, first, repeat };

  // Call it when a frame was drawn with the state that came at received_ns, or was skipped because it would look the same. Only the first
  // acknowledgement of a state (`first`) tells how old the state was when it was shown.
  Kind note(std::int64_t received_ns, std::int64_t now_ns) noexcept {
    const bool is_first = std::exchange(received_ns_, received_ns) != received_ns;
    if (!is_first && now_ns < next_repeat_ns_) return Kind::none;
    next_repeat_ns_ = now_ns + kRepeatPeriodNs;
    return is_first ? Kind::first : Kind::repeat;
  }

 private:
  std::int64_t received_ns_ = 0;
  std::int64_t next_repeat_ns_ = 0;
};

}  // namespace hapton
