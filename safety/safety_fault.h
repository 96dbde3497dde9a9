#pragma once

#include <cstdint>
#include <string_view>

namespace hapton {

// A latched fault: no force until a person resets it. The first one is kept until then.
enum class SafetyFault : std::uint8_t {
  none,
  not_finite,  // repeated forces that are not finite
  torque,      // repeated torques that are not finite
  speed,       // the device is faster than any hand
  position,    // repeated invalid poses
  jump,        // the position jumped: an encoder may have lost count
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
  away,             // the device is not there
  calibrating,      // the device is not ready
  pose_timeout,     // pose timeout: no valid sample of the device for 20 ms
  switch_released,  // the dead man's switch
  no_command,       // no force command within the command timeout
  ramping,          // the force ramps up
  live,
};
std::string_view to_string(GovernorState state) noexcept;

}  // namespace hapton
