#pragma once

#include <algorithm>
#include <cstdint>

namespace hapton {

// Decides whether spinning for a datagram saves anything. It saves nothing if the sender needs the CPU on which this thread spins, or sends
// so late that the datagram comes after the end of the spinning. Of each kWaits waits that spin, half must end with the datagram; otherwise
// the next kFirstPause waits do not spin, and twice as many as the last time after each further failure. RT: yes. Threads: one.
class SpinTrial {
 public:
  static constexpr std::uint32_t kWaits = 6;               // waits of a trial; a free choice
  static constexpr std::uint32_t kFirstPause = 512;        // half a second at 1 kHz: a trial that fails costs a hundredth of the waits
  static constexpr std::uint32_t kLongestPause = 1 << 20;  // waits: 17 minutes at 1 kHz; a free choice

  // Whether the next wait may spin. Called once for each wait.
  bool may_spin() noexcept {
    if (pause_left_ == 0) return true;
    --pause_left_;
    return false;
  }

  // Called after each wait that did spin. has_arrived: the datagram came before the end of the spinning.
  void note(bool has_arrived) noexcept {
    arrivals_ += has_arrived ? 1 : 0;
    if (++waits_ < kWaits) return;
    if (2 * arrivals_ >= kWaits) {
      next_pause_ = kFirstPause;
    } else {
      pause_left_ = next_pause_;
      next_pause_ = std::min(2 * next_pause_, kLongestPause);
    }
    waits_ = arrivals_ = 0;
  }

 private:
  std::uint32_t waits_ = 0;
  std::uint32_t arrivals_ = 0;
  std::uint32_t pause_left_ = 0;  // further waits that must not spin
  std::uint32_t next_pause_ = kFirstPause;
};

}  // namespace hapton
