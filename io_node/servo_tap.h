#pragma once

#include <cstdint>

#include "link/datagram_tap.h"
#include "link/session_entry.h"

namespace hapton {

// Hears what a servo does: its datagrams, its cycles and its faults.
// Units: the servo's clock, ns. RT: yes. Threads: the servo's.
class ServoTap : public DatagramTap {
 public:
  virtual void on_cycle(const CycleNote& note, std::int64_t time_ns) noexcept = 0;
  virtual void on_fault(SessionFault fault, std::int64_t time_ns) noexcept = 0;
};

}  // namespace hapton
