#include "io_node/safety_news.h"

#include "io_node/session_fault_of.h"

namespace hapton {

void SafetyNews::tell(ServoEvent::Kind kind, SafetyFault fault) noexcept { events_.push({kind, NodeRole::tool, {}, 0.0, {}, fault}); }
void SafetyNews::tell_status(ServoEvent::Kind kind) noexcept { events_.push({kind, NodeRole::io, {}, 0.0, {}, {}}); }

// People first: they may have to do something about it.
void SafetyNews::look(const DeviceSide& side, const DeviceCycle& cycle, bool is_missed, std::int64_t now_ns) noexcept {
  const GovernorCounters& governor = side.governor.counters;
  if (governor.latched > governor_told_.latched) tell(ServoEvent::Kind::latched, side.governor.fault);
  if (governor.resets > governor_told_.resets) tell(ServoEvent::Kind::reset, fault_told_);
  if (governor.resets_refused > governor_told_.resets_refused) tell(ServoEvent::Kind::reset_refused, side.governor.fault);
  fault_told_ = side.governor.fault;
  if (side.status == status_told_) status_since_ns_ = now_ns;
  if (now_ns - status_since_ns_ >= kStatusNs) {
    if (side.status == DeviceStatus::away) tell_status(ServoEvent::Kind::away);
    if (side.status == DeviceStatus::calibrating) tell_status(ServoEvent::Kind::calibrating);
    if (side.status == DeviceStatus::ready) tell_status(ServoEvent::Kind::back);
    status_told_ = side.status;
  }
  if (tap_ != nullptr) tell_tap(side, cycle, is_missed, now_ns);
  governor_told_ = governor;
}

void SafetyNews::note_cycle(const DeviceSide& side, const DeviceCycle& cycle, std::int64_t now_ns) noexcept {
  tap_->on_cycle(
      {.sample = cycle.number, .late_ns = cycle.late_ns, .written_n = side.written.force_n, .missed = cycle.missed, .cause = cycle.cause},
      now_ns);
}

void SafetyNews::tell_tap(const DeviceSide& side, const DeviceCycle& cycle, bool is_missed, std::int64_t now_ns) noexcept {
  note_cycle(side, cycle, now_ns);
  const GovernorCounters& governor = side.governor.counters;
  tell_fault(SessionFault::silence, governor.silences > governor_told_.silences && is_missed, now_ns);
  tell_fault(SessionFault::not_finite, governor.not_finite > governor_told_.not_finite, now_ns);
  tell_fault(SessionFault::refused_future, governor.refused_future > governor_told_.refused_future, now_ns);
  tell_fault(SessionFault::clamped, governor.clamped > governor_told_.clamped, now_ns);
  tell_fault(SessionFault::stalled, cycle.late_ns >= kSilenceLimitNs, now_ns);
  tell_fault(SessionFault::overrun, side.has_overrun, now_ns);
  tell_fault(SessionFault::energy, side.is_energy_gone, now_ns);
  if (governor.latched > governor_told_.latched) tap_->on_fault(session_fault_of(side.governor.fault), now_ns);
}

// Once when it begins: a force that stays above the limit is one fault.
void SafetyNews::tell_fault(SessionFault fault, bool is_there, std::int64_t now_ns) noexcept {
  const std::uint32_t bit = std::uint32_t{1} << static_cast<unsigned>(fault);
  if (is_there && (faults_ & bit) == 0) tap_->on_fault(fault, now_ns);
  faults_ = is_there ? faults_ | bit : faults_ & ~bit;
}

}  // namespace hapton
