#pragma once

#include <cstdint>
#include <string_view>

namespace hapton {

// Why there is no force until a person says so. The first that comes is kept until the reset.
enum class SafetyFault : std::uint8_t {
  none,
  not_finite,  // forces that are no numbers, again and again
  torque,      // torques that are no numbers, again and again
  speed,       // the device is faster than any hand
  position,    // positions that are no positions, again and again
  jump,        // the position leapt: an encoder has lost count
  thermal,     // the motors are too hot
  device,      // the device has stopped answering
};
constexpr int kSafetyFaults = 8;

// "speed": for names of files and counters.
std::string_view to_string(SafetyFault fault) noexcept;
// "the device moved faster than its limit": for people.
std::string_view describe(SafetyFault fault) noexcept;

// What the governor does at the moment; the first that holds, from the top.
enum class GovernorState : std::uint8_t {
  latched,      // a fault holds the force at zero until it is reset
  away,         // the device is not there
  calibrating,  // the device is not ready
  blind,        // no good sample of the device for 20 ms
  not_held,     // the dead man's switch
  silent,       // nobody asks for a force
  ramping,      // the force comes in
  live,
};
std::string_view to_string(GovernorState state) noexcept;

}  // namespace hapton
