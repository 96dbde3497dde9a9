#include "io_node/safety_notices.h"

#include <algorithm>
#include <utility>

#include "io_node/session_fault_of.h"

namespace hapton {

void SafetyNotices::notify(ServoEvent::Kind kind, SafetyFault fault) noexcept { events_.push({kind, NodeRole::tool, {}, 0.0, {}, fault}); }
void SafetyNotices::notify_status(ServoEvent::Kind kind) noexcept { events_.push({kind, NodeRole::io, {}, 0.0, {}, {}}); }

// Calls visit(fault, times) for each kind of fault that was latched since the last check, even if it was reset meanwhile.
template <class Visit>
void SafetyNotices::for_each_latched(const GovernorStats& governor, Visit&& visit) const noexcept {
  for (std::size_t n = 1; n < kSafetyFaults; ++n) {
    const std::uint64_t times = governor.counters.faults[n] - governor_noted_.faults[n];
    if (times > 0) visit(static_cast<SafetyFault>(n), times);
  }
}

// If both a reset and a new fault came since the last check, the fault is the present state: its notice must be the last.
void SafetyNotices::notify_faults(const GovernorStats& governor) noexcept {
  const GovernorCounters& counters = governor.counters;
  SafetyFault reset = fault_noted_;
  for_each_latched(governor, [&](SafetyFault fault, std::uint64_t times) {
    if (fault == governor.fault && times == 1) return;
    notify(ServoEvent::Kind::latched, fault);
    reset = fault;
  });
  if (counters.resets > governor_noted_.resets) notify(ServoEvent::Kind::reset, reset);
  const bool has_latched = counters.latched > governor_noted_.latched;
  if (has_latched && governor.fault != SafetyFault::none) notify(ServoEvent::Kind::latched, governor.fault);
  if (counters.resets_rejected > governor_noted_.resets_rejected) notify(ServoEvent::Kind::reset_rejected, governor.fault);
  fault_noted_ = governor.fault;
}

// Notifies people before it records anything: they may have to act.
void SafetyNotices::check(const DeviceSide& side, const DeviceCycle& cycle, bool is_timeout_fault, std::int64_t now_ns) noexcept {
  notify_faults(side.governor);
  if (side.status == status_noted_) status_since_ns_ = now_ns;
  if (now_ns - status_since_ns_ >= kStatusNs) {
    if (side.status == DeviceStatus::away) notify_status(ServoEvent::Kind::away);
    if (side.status == DeviceStatus::calibrating) notify_status(ServoEvent::Kind::calibrating);
    if (side.status == DeviceStatus::ready) notify_status(ServoEvent::Kind::back);
    status_noted_ = side.status;
  }
  if (tap_ != nullptr) record(side, cycle, is_timeout_fault, now_ns);
  governor_noted_ = side.governor.counters;
}

void SafetyNotices::note_overtaken(const DeviceCycle& cycle, std::int64_t now_ns) noexcept {
  max_late_ns_ = std::max(max_late_ns_, cycle.late_ns);
  if (tap_ != nullptr) note_cycle({}, cycle, false, now_ns);
}

void SafetyNotices::finish(const DeviceSide& side, DeviceStatus status, std::int64_t now_ns) noexcept {
  notify_faults(side.governor);
  if (tap_ != nullptr) record_latched(side.governor, now_ns);
  governor_noted_ = side.governor.counters;
  if (tap_ != nullptr && status == DeviceStatus::fault && !is_failure_recorded_) tap_->on_fault(SessionFault::device, now_ns);
}

void SafetyNotices::note_cycle(const DeviceSide& side, const DeviceCycle& cycle, bool is_newest, std::int64_t now_ns) noexcept {
  // For the newest cycle, the force that is on the motors now: the reply to its sample may have come since the end of the cycle.
  const Wrench& written = is_newest && !cycle.local ? side.written : cycle.written;
  const DeviceSample& sample = cycle.sample;
  CycleNote note{.sample = cycle.number,
                 .late_ns = cycle.late_ns,
                 .written_n = written.force_n,
                 .written_nm = written.torque_nm,
                 .missed = cycle.missed,
                 .cause = cycle.cause,
                 .device = CycleSample{sample.time_ns, sample.p_WD, sample.q_WT, sample.buttons}};
  if (cycle.local) note.local = CycleLocal{cycle.local->force_n, cycle.local->visual_offset_m, cycle.local->object};
  tap_->on_cycle(note, now_ns);
}

void SafetyNotices::record(const DeviceSide& side, const DeviceCycle& cycle, bool is_timeout_fault, std::int64_t now_ns) noexcept {
  note_cycle(side, cycle, true, now_ns);
  const GovernorCounters& governor = side.governor.counters;
  record_fault(SessionFault::command_timeout, governor.command_timeouts > governor_noted_.command_timeouts && is_timeout_fault, now_ns);
  record_fault(SessionFault::not_finite, governor.not_finite > governor_noted_.not_finite, now_ns);
  record_fault(SessionFault::rejected_future, governor.rejected_future > governor_noted_.rejected_future, now_ns);
  record_fault(SessionFault::clamped, governor.clamped > governor_noted_.clamped, now_ns);
  record_fault(SessionFault::stalled, std::max(cycle.late_ns, std::exchange(max_late_ns_, 0)) >= kCommandTimeoutNs, now_ns);
  record_fault(SessionFault::overrun, side.has_overrun, now_ns);
  record_fault(SessionFault::energy, side.is_energy_gone, now_ns);
  record_latched(side.governor, now_ns);
}

void SafetyNotices::record_latched(const GovernorStats& governor, std::int64_t now_ns) noexcept {
  for_each_latched(governor, [&](SafetyFault fault, std::uint64_t) { tap_->on_fault(session_fault_of(fault), now_ns); });
  const bool has_latched = governor.counters.latched > governor_noted_.latched;
  is_failure_recorded_ = governor.fault == SafetyFault::device && (has_latched || is_failure_recorded_);
}

// Records a fault once, when it begins: a force that stays above the limit is one fault.
void SafetyNotices::record_fault(SessionFault fault, bool is_active, std::int64_t now_ns) noexcept {
  const std::uint32_t bit = std::uint32_t{1} << static_cast<unsigned>(fault);
  if (is_active && (active_faults_ & bit) == 0) tap_->on_fault(fault, now_ns);
  active_faults_ = is_active ? active_faults_ | bit : active_faults_ & ~bit;
}

}  // namespace hapton
