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

// Reports each fault and change of state of governor and device once: to people (the event ring) and to the recording (the tap).
// RT: yes. Threads: one.
class SafetyNotices {
 public:
  // How long a device must be disconnected, or calibrating, before that is reported.
  static constexpr std::int64_t kStatusNs = 100 * kNanosecondsPerMillisecond;

  // Pre: both outlive this; tap may be null.
  SafetyNotices(EventRing& events, ServoTap* tap) noexcept : events_(events), tap_(tap) {}

  void start(std::int64_t now_ns) noexcept { status_since_ns_ = now_ns; }
  // Call once a cycle. is_timeout_fault: the hand was in contact and the haptics node is there, so a command timeout counts as a fault.
  void check(const DeviceSide& side, const DeviceCycle& cycle, bool is_timeout_fault, std::int64_t now_ns) noexcept;
  // Notes a cycle that a newer one has overtaken: for the recording, and for the faults of the next check.
  void note_overtaken(const DeviceCycle& cycle, std::int64_t now_ns) noexcept;
  // Call at the end. Reports faults latched since the last check, and a device that has failed if no check has seen that fault latched.
  void finish(const DeviceSide& side, DeviceStatus status, std::int64_t now_ns) noexcept;

 private:
  void note_cycle(const DeviceSide& side, const DeviceCycle& cycle, bool is_newest, std::int64_t now_ns) noexcept;
  template <class Visit>
  void for_each_latched(const GovernorStats& governor, Visit&& visit) const noexcept;
  void notify_faults(const GovernorStats& governor) noexcept;
  void record_latched(const GovernorStats& governor, std::int64_t now_ns) noexcept;
  void notify(ServoEvent::Kind kind, SafetyFault fault) noexcept;
  void notify_status(ServoEvent::Kind kind) noexcept;
  void record(const DeviceSide& side, const DeviceCycle& cycle, bool is_timeout_fault, std::int64_t now_ns) noexcept;
  void record_fault(SessionFault fault, bool is_active, std::int64_t now_ns) noexcept;

  EventRing& events_;
  ServoTap* tap_;
  SafetyFault fault_noted_ = SafetyFault::none;
  GovernorCounters governor_noted_;
  DeviceStatus status_noted_ = DeviceStatus::ready;
  std::int64_t status_since_ns_ = 0;  // time of the newest check that found the status noted
  std::uint32_t active_faults_ = 0;   // faults of the newest cycle, a bit for each kind
  std::int64_t max_late_ns_ = 0;      // largest lateness of the cycles overtaken since the last check
  bool is_failure_recorded_ = false;  // the recording has the device fault that is latched now
};

}  // namespace hapton
