#pragma once

#include <array>
#include <cstdint>

namespace hapton {

enum class Arrival : std::uint8_t {
  newest,     // newer than all before: use it
  reordered,  // new, but older than the newest: most receivers drop it
  duplicate,  // seen before, or too old to check
  stale,      // from the previous sender, which the present one replaced
};

struct SequenceCounts {
  std::uint64_t received = 0;  // every call of track()
  std::uint64_t lost = 0;      // missing numbers that have not arrived so far
  std::uint64_t reordered = 0;
  std::uint64_t duplicate = 0;
  std::uint64_t stale = 0;
  std::uint64_t restarts = 0;  // new sender ids after the first
  std::uint64_t jumps = 0;     // jumps too large to be loss; counting starts again after them
};

// Classifies the sequence numbers of one sender's datagrams and counts losses. Numbers are compared modulo 2^64.
// RT: yes. Threads: one.
class SequenceTracker {
 public:
  // A number this far or farther behind the newest counts as a duplicate.
  static constexpr std::uint64_t kWindow = 1024;
  // A larger jump (100 s at 10 kHz), in either direction, is not a loss: the sender has restarted its count.
  static constexpr std::uint64_t kMaxGap = 1'000'000;

  // may_restart: the sender has joined again, so a number behind the newest means that it has restarted its count at that number.
  Arrival track(std::uint64_t sender, std::uint64_t sequence, bool may_restart = false) noexcept;

  const SequenceCounts& counts() const noexcept { return counts_; }
  // The newest sender and its newest number: both 0 before the first datagram.
  std::uint64_t sender() const noexcept { return sender_; }
  std::uint64_t newest() const noexcept { return newest_; }

 private:
  static constexpr std::uint64_t kWords = kWindow / 64;

  void start(std::uint64_t sequence) noexcept;
  Arrival advance(std::uint64_t gap) noexcept;
  Arrival check_late_arrival(std::uint64_t sequence, std::uint64_t age) noexcept;
  bool test_and_mark(std::uint64_t sequence) noexcept;

  SequenceCounts counts_;
  std::uint64_t sender_ = 0;
  std::uint64_t previous_sender_ = 0;
  std::uint64_t newest_ = 0;
  std::uint64_t first_ = 0;                      // the number at which counting began
  std::array<std::uint64_t, kWords> seen_ = {};  // bit sequence % kWindow: numbers (newest - kWindow, newest]
};

}  // namespace hapton
