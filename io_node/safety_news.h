#pragma once

#include <cstdint>

#include "io_node/device_loop.h"
#include "io_node/event_ring.h"
#include "io_node/servo_tap.h"
#include "link/session_entry.h"
#include "runtime/clock.h"
#include "safety/safety_fault.h"
#include "safety/safety_governor.h"

namespace hapton {

// What the device side's governor and device have come to, told once each: to people (the event ring), and to the recording (the tap).
// RT: yes. Threads: one.
class SafetyNews {
 public:
  // A device is away, or being calibrated, for so long before it is told.
  static constexpr std::int64_t kStatusNs = 100 * kNanosecondsPerMillisecond;

  // Pre: both outlive this; tap may be null.
  SafetyNews(EventRing& events, ServoTap* tap) noexcept : events_(events), tap_(tap) {}

  void start(std::int64_t now_ns) noexcept { status_since_ns_ = now_ns; }
  // Once a cycle. is_missed: a silence would be a loss to the hand, which was in contact with a node that is still there.
  void look(const DeviceSide& side, const DeviceCycle& cycle, bool is_missed, std::int64_t now_ns) noexcept;
  // A cycle that a newer one has overtaken already. Pre: there is a tap.
  void note_cycle(const DeviceSide& side, const DeviceCycle& cycle, std::int64_t now_ns) noexcept;

 private:
  void tell(ServoEvent::Kind kind, SafetyFault fault) noexcept;
  void tell_status(ServoEvent::Kind kind) noexcept;
  void tell_tap(const DeviceSide& side, const DeviceCycle& cycle, bool is_missed, std::int64_t now_ns) noexcept;
  void tell_fault(SessionFault fault, bool is_there, std::int64_t now_ns) noexcept;

  EventRing& events_;
  ServoTap* tap_;
  SafetyFault fault_told_ = SafetyFault::none;
  GovernorCounters governor_told_;
  DeviceStatus status_told_ = DeviceStatus::ready;
  std::int64_t status_since_ns_ = 0;  // the newest cycle with that status
  std::uint32_t faults_ = 0;          // of the newest cycle, a bit each
};

}  // namespace hapton
