#include "safety/safety_fault.h"

namespace hapton {

std::string_view to_string(SafetyFault fault) noexcept {
  switch (fault) {
    case SafetyFault::none:
      return "none";
    case SafetyFault::not_finite:
      return "not-finite";
    case SafetyFault::torque:
      return "torque";
    case SafetyFault::speed:
      return "speed";
    case SafetyFault::position:
      return "position";
    case SafetyFault::jump:
      return "jump";
    case SafetyFault::thermal:
      return "thermal";
    case SafetyFault::device:
      return "device";
  }
  return "unknown";
}

std::string_view describe(SafetyFault fault) noexcept {
  switch (fault) {
    case SafetyFault::none:
      return "no fault";
    case SafetyFault::not_finite:
      return "forces came that are no numbers, again and again";
    case SafetyFault::torque:
      return "torques came that are no numbers, again and again";
    case SafetyFault::speed:
      return "the device moved faster than its limit";
    case SafetyFault::position:
      return "the device told positions that are none, again and again";
    case SafetyFault::jump:
      return "the device's position leapt, an encoder may have lost count";
    case SafetyFault::thermal:
      return "the motors are too hot";
    case SafetyFault::device:
      return "the device stopped answering";
  }
  return "unknown";
}

std::string_view to_string(GovernorState state) noexcept {
  switch (state) {
    case GovernorState::latched:
      return "latched";
    case GovernorState::away:
      return "away";
    case GovernorState::calibrating:
      return "calibrating";
    case GovernorState::blind:
      return "blind";
    case GovernorState::not_held:
      return "not held";
    case GovernorState::silent:
      return "silent";
    case GovernorState::ramping:
      return "ramping";
    case GovernorState::live:
      return "live";
  }
  return "unknown";
}

}  // namespace hapton
