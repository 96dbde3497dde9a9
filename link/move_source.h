#pragma once

#include <cstdint>

#include "link/messages.h"
#include "link/sequence_tracker.h"

namespace hapton {

// Whose moves of objects, or carves, count: those of the haptics process that announced its own last. Serials and scene time begin again in
// another process, and its objects are where the scene file has them, and whole. RT: yes. Threads: one.
class MoveSource {
 public:
  enum class Verdict : std::uint8_t {
    known,  // of the process whose moves are known
    other,  // of another one: the moves known so far are void
    old,    // of a process that another one has replaced; the datagram was overtaken
  };

  // arrival: as HubClient::last_arrival of this move.
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
