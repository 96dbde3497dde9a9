#include "safety/safety_fault.h"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <string_view>
#include <utility>

namespace hapton {
namespace {

// Reports, recordings and the file of a latched fault are read by these names.
TEST(SafetyFaults, EachFaultAndEachStateHasItsName) {
  constexpr std::array<std::string_view, 8> kFaults = {"none", "not-finite", "torque", "speed", "position", "jump", "thermal", "device"};
  static_assert(kFaults.size() == kSafetyFaults);
  for (std::size_t n = 0; n < kFaults.size(); ++n) EXPECT_EQ(to_string(static_cast<SafetyFault>(n)), kFaults[n]) << n;
  for (const auto& [state, name] :
       {std::pair(GovernorState::latched, "latched"), std::pair(GovernorState::away, "away"),
        std::pair(GovernorState::calibrating, "calibrating"), std::pair(GovernorState::pose_timeout, "pose timeout"),
        std::pair(GovernorState::switch_released, "switch released"), std::pair(GovernorState::no_command, "no command"),
        std::pair(GovernorState::ramping, "ramping"), std::pair(GovernorState::live, "live")}) {
    EXPECT_EQ(to_string(state), name);
  }
}

// The descriptions are for a person, who has to know what to look for.
TEST(SafetyFaults, EachFaultIsDescribedAsItself) {
  EXPECT_EQ(describe(SafetyFault::none), "no fault");
  EXPECT_EQ(describe(SafetyFault::not_finite), "repeated forces that are not finite");
  EXPECT_EQ(describe(SafetyFault::torque), "repeated torques that are not finite");
  EXPECT_EQ(describe(SafetyFault::speed), "the device moved faster than its limit");
  EXPECT_EQ(describe(SafetyFault::position), "repeated invalid poses from the device");
  EXPECT_EQ(describe(SafetyFault::jump), "the device's position jumped; an encoder may have lost count");
  EXPECT_EQ(describe(SafetyFault::thermal), "the motors are too hot");
  EXPECT_EQ(describe(SafetyFault::device), "the device stopped replying");
}

}  // namespace
}  // namespace hapton
