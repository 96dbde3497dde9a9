#pragma once

#include <array>
#include <cstdint>

namespace hapton {

// Remembers which counters of a session were seen; they begin at 1. Each is accepted once; one kSpan or more behind the newest never is.
// Check first, open the seal, then mark: a forged datagram must leave no mark. RT: yes. Threads: one.
class ReplayWindow {
 public:
  static constexpr std::uint64_t kSpan = 1024;  // 100 ms at 10 kHz

  bool is_fresh(std::uint64_t counter) const noexcept {
    if (counter > newest_) return true;
    return counter != 0 && newest_ - counter < kSpan && (word(counter) & bit(counter)) == 0;
  }

  // Pre: is_fresh(counter).
  void mark(std::uint64_t counter) noexcept {
    if (counter > newest_) {
      if (counter - newest_ >= kSpan) {
        seen_ = {};
      } else {
        for (std::uint64_t skipped = newest_ + 1; skipped <= counter; ++skipped) seen_[index_of(skipped)] &= ~bit(skipped);
      }
      newest_ = counter;
    }
    seen_[index_of(counter)] |= bit(counter);
  }

 private:
  static constexpr std::size_t index_of(std::uint64_t counter) noexcept { return counter % kSpan / 64; }
  static constexpr std::uint64_t bit(std::uint64_t counter) noexcept { return std::uint64_t{1} << (counter % 64); }
  std::uint64_t word(std::uint64_t counter) const noexcept { return seen_[index_of(counter)]; }

  std::uint64_t newest_ = 0;
  std::array<std::uint64_t, kSpan / 64> seen_ = {};
};

}  // namespace hapton
