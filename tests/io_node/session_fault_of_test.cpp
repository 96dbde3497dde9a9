#include "io_node/session_fault_of.h"

#include <gtest/gtest.h>

#include <string>

namespace hapton {
namespace {

// Whoever reads a recording goes by the names of its faults.
TEST(SessionFaultOf, EachLatchedFaultHasItsOwnNameInARecording) {
  for (int n = 0; n < kSafetyFaults; ++n) {
    const auto fault = static_cast<SafetyFault>(n);
    EXPECT_EQ(to_string(session_fault_of(fault)), to_string(fault)) << n;
  }
  EXPECT_EQ(session_fault_of(SafetyFault::torque), SessionFault::torque);
  EXPECT_EQ(session_fault_of(SafetyFault::none), SessionFault::none);
}

}  // namespace
}  // namespace hapton
