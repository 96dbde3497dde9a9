#pragma once

#include <cstdint>
#include <string_view>

namespace hapton {

// A latched fault: no force until a person resets it. The first fault stays latched until then, and later ones are not.
enum class SafetyFault : std::uint8_t {
  none,
  not_finite,  // repeated forces that are not finite
  torque,      // repeated torques that are not finite
  speed,       // the device is faster than max_speed
  position,    // repeated invalid poses
  jump,        // the position or orientation jumped: an encoder may have lost count
  thermal,     // the motors are too hot
  device,      // the device has stopped replying
};
constexpr int kSafetyFaults = 8;

// "speed": for names of files and counters.
std::string_view to_string(SafetyFault fault) noexcept;
// "the device moved faster than its limit": for people.
std::string_view describe(SafetyFault fault) noexcept;

// What the governor does now: the first that applies, from the top.
enum class GovernorState : std::uint8_t {
  latched,          // a fault holds the force at zero until it is reset
  away,             // the device is unplugged or does not respond
  calibrating,      // the position of the device is not valid yet
  pose_timeout,     // no valid sample of the device for 20 ms
  switch_released,  // the dead man's switch is not held
  no_command,       // no force command within the command timeout
  ramping,          // the force is ramping up
  live,
};
std::string_view to_string(GovernorState state) noexcept;

}  // namespace hapton
