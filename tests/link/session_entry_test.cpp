#include "link/session_entry.h"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <string_view>

namespace hapton {
namespace {

// People search exports, reports and flight records for these names.
TEST(SessionEntries, EachFaultAndEachCauseHasItsName) {
  constexpr std::array<std::string_view, 14> kFaults = {"none",    "command-timeout", "not-finite", "rejected-future", "clamped",
                                                        "stalled", "device",          "overrun",    "speed",           "position",
                                                        "jump",    "thermal",         "torque",     "energy"};
  for (std::size_t n = 0; n < kFaults.size(); ++n) EXPECT_EQ(to_string(static_cast<SessionFault>(n)), kFaults[n]) << n;
  constexpr std::array<std::string_view, 5> kCauses = {"none", "late wake-up", "device slow", "work long", "machine stalled"};
  for (std::size_t n = 0; n < kCauses.size(); ++n) EXPECT_EQ(to_string(static_cast<MissCause>(n)), kCauses[n]) << n;
}

// A later version may write recordings with faults and causes that this version does not know.
TEST(SessionEntries, WhatIsNotKnownIsCalledUnknown) {
  EXPECT_EQ(to_string(static_cast<SessionFault>(200)), "unknown");
  EXPECT_EQ(to_string(static_cast<MissCause>(200)), "unknown");
}

}  // namespace
}  // namespace hapton
