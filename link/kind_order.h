#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <variant>

#include "link/messages.h"
#include "link/sequence_tracker.h"

namespace hapton {

// The order of one sender's messages, for each kind separately. A message is outdated only if a newer one of its own kind came before it: a
// setup that is sent once a second stays valid although a force that was sent a millisecond later came first.
// RT: yes. Threads: one.
class KindOrder {
 public:
  // Returns reordered if a newer message of this kind has arrived before, else newest. Pre: `tracker` has just tracked this sequence number
  // as `arrival`, newest or reordered.
  Arrival note(const SequenceTracker& tracker, Arrival arrival, const Message& message, std::uint64_t sequence) noexcept {
    const std::uint64_t beginnings = tracker.counts().restarts + tracker.counts().jumps;
    if (beginnings != beginnings_) {
      known_.reset();
      beginnings_ = beginnings;
    }
    const std::size_t kind = message.index();
    const bool is_overtaken = arrival == Arrival::reordered && known_[kind] && static_cast<std::int64_t>(sequence - newest_[kind]) < 0;
    if (is_overtaken) return Arrival::reordered;
    known_[kind] = true;
    newest_[kind] = sequence;
    return Arrival::newest;
  }

 private:
  static constexpr std::size_t kKinds = std::variant_size_v<Message>;

  std::array<std::uint64_t, kKinds> newest_ = {};
  std::bitset<kKinds> known_;  // kinds that have arrived since the sender began to count
  std::uint64_t beginnings_ = 0;
};

}  // namespace hapton
