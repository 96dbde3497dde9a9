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
      return "repeated forces that are not finite";
    case SafetyFault::torque:
      return "repeated torques that are not finite";
    case SafetyFault::speed:
      return "the device moved faster than its limit";
    case SafetyFault::position:
      return "repeated invalid poses from the device";
    case SafetyFault::jump:
      return "the device's position jumped; an encoder may have lost count";
    case SafetyFault::thermal:
      return "the motors are too hot";
    case SafetyFault::device:
      return "the device stopped replying";
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
    case GovernorState::pose_timeout:
      return "pose timeout";
    case GovernorState::switch_released:
      return "switch released";
    case GovernorState::no_command:
      return "no command";
    case GovernorState::ramping:
      return "ramping";
    case GovernorState::live:
      return "live";
  }
  return "unknown";
}

}  // namespace hapton
