#include "link/sequence_tracker.h"

namespace hapton {

Arrival SequenceTracker::track(std::uint64_t sender, std::uint64_t sequence, bool may_restart) noexcept {
  ++counts_.received;
  const bool is_first = counts_.received == 1;
  if (is_first || sender != sender_) {
    if (!is_first && sender == previous_sender_) {
      ++counts_.stale;
      return Arrival::stale;
    }
    counts_.restarts += is_first ? 0 : 1;
    previous_sender_ = is_first ? sender : sender_;
    sender_ = sender;
    start(sequence);
    return Arrival::newest;
  }
  const std::uint64_t ahead = sequence - newest_;
  const std::uint64_t behind = newest_ - sequence;
  if (ahead != 0 && ahead <= kMaxGap) {
    return advance(ahead);
  }
  if (behind <= kMaxGap && !(may_restart && behind > 0)) {
    return check_late_arrival(sequence, behind);
  }
  ++counts_.jumps;
  start(sequence);
  return Arrival::newest;
}

void SequenceTracker::start(std::uint64_t sequence) noexcept {
  seen_ = {};
  newest_ = sequence;
  first_ = sequence;
  test_and_mark(sequence);
}

Arrival SequenceTracker::advance(std::uint64_t gap) noexcept {
  counts_.lost += gap - 1;
  if (gap >= kWindow) {
    seen_ = {};
  } else {
    for (std::uint64_t skipped = newest_ + 1; skipped != newest_ + gap; ++skipped) {
      seen_[skipped % kWindow / 64] &= ~(std::uint64_t{1} << (skipped % 64));
    }
    const std::uint64_t next = newest_ + gap;
    seen_[next % kWindow / 64] &= ~(std::uint64_t{1} << (next % 64));
  }
  newest_ += gap;
  test_and_mark(newest_);
  return Arrival::newest;
}

Arrival SequenceTracker::check_late_arrival(std::uint64_t sequence, std::uint64_t age) noexcept {
  if (age >= kWindow || test_and_mark(sequence)) {
    ++counts_.duplicate;
    return Arrival::duplicate;
  }
  ++counts_.reordered;
  // Numbers before the first one were never counted as lost.
  if (newest_ - first_ >= age && counts_.lost > 0) {
    --counts_.lost;
  }
  return Arrival::reordered;
}

bool SequenceTracker::test_and_mark(std::uint64_t sequence) noexcept {
  std::uint64_t& word = seen_[sequence % kWindow / 64];
  const std::uint64_t bit = std::uint64_t{1} << (sequence % 64);
  const bool was_seen = (word & bit) != 0;
  word |= bit;
  return was_seen;
}

}  // namespace hapton
