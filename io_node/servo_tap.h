#pragma once

#include <cstdint>

#include "link/datagram_tap.h"
#include "link/session_entry.h"

namespace hapton {

// Receives a copy of everything that device side and network side do: datagrams, cycles and faults. Units: ns of the hub's clock. RT: yes.
// Threads: the network side's.
class ServoTap : public DatagramTap {
 public:
  virtual void on_cycle(const CycleNote& note, std::int64_t time_ns) noexcept = 0;
  virtual void on_fault(SessionFault fault, std::int64_t time_ns) noexcept = 0;
  // True: everything goes into a file; false: at most what came before a fault.
  virtual bool is_recording() const noexcept = 0;
  // Returns recorded, no_recording or no_room.
  virtual MarkerStatus on_marker(const MarkerNote& note, std::int64_t time_ns) noexcept = 0;
};

}  // namespace hapton
