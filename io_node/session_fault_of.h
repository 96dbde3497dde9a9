#pragma once

#include "link/session_entry.h"
#include "safety/safety_fault.h"

namespace hapton {

// The fault that stands for a latched fault in a recording. RT: yes.
inline SessionFault session_fault_of(SafetyFault fault) noexcept {
  switch (fault) {
    case SafetyFault::none:
      break;
    case SafetyFault::not_finite:
      return SessionFault::not_finite;
    case SafetyFault::torque:
      return SessionFault::torque;
    case SafetyFault::speed:
      return SessionFault::speed;
    case SafetyFault::position:
      return SessionFault::position;
    case SafetyFault::jump:
      return SessionFault::jump;
    case SafetyFault::thermal:
      return SessionFault::thermal;
    case SafetyFault::device:
      return SessionFault::device;
  }
  return SessionFault::none;
}

}  // namespace hapton
