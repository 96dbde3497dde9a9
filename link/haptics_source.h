#pragma once

#include <cstdint>

#include "link/messages.h"
#include "link/sequence_tracker.h"

namespace hapton {

// Tells which haptics process the known moves, carves or shapes come from: the newest that has sent any. In another process serials and
// scene time begin again, and its objects are whole and where the scene file places them. RT: yes. Threads: one.
class HapticsSource {
 public:
  enum class Verdict : std::uint8_t {
    known,  // the message is from this process
    other,  // it is from another process, which replaces it: all moves, carves and shapes so far are void
    old,    // it is from a process that was replaced, and came late: ignore it
  };

  // Takes the source of a message. arrival: HubClient::last_arrival of this message.
  Verdict note(const ObjectMove& move, Arrival arrival) noexcept { return note(move.source, arrival); }
  Verdict note(std::uint32_t source, Arrival arrival) noexcept {
    if (source == source_) return Verdict::known;
    if (arrival == Arrival::reordered && source_ != 0) return Verdict::old;
    source_ = source;
    return Verdict::other;
  }

 private:
  std::uint32_t source_ = 0;  // 0: none yet
};

}  // namespace hapton
