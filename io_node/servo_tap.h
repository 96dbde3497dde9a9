#pragma once

#include <cstdint>

#include "link/datagram_tap.h"
#include "link/session_entry.h"

namespace hapton {

// Receives a copy of everything a servo does: datagrams, cycles and faults. Units: the servo's clock, ns. RT: yes. Threads: the
// servo's.
class ServoTap : public DatagramTap {
 public:
  virtual void on_cycle(const CycleNote& note, std::int64_t time_ns) noexcept = 0;
  virtual void on_fault(SessionFault fault, std::int64_t time_ns) noexcept = 0;
  // Everything goes into a file, not only what came before a fault.
  virtual bool is_recording() const noexcept = 0;
  // recorded, no_recording or no_room.
  virtual MarkerStatus on_marker(const MarkerNote& note, std::int64_t time_ns) noexcept = 0;
};

}  // namespace hapton
