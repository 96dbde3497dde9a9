#include "io_node/loop_reporter.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/io_node/network_loop_fixture.h"

namespace hapton {
namespace {

using LoopReports = NetworkLoops;

TEST_F(LoopReports, ComeOnceASecondWhenEnoughIsMeasured) {
  make();
  join(kHaptics, NodeRole::haptics);
  join(kVision, NodeRole::vision);
  run(static_cast<int>(LoopReporter::kMinTrips) - 100);
  EXPECT_TRUE(loop_facts.empty());
  run(3200);
  ASSERT_GE(loop_facts.size(), 3U);
  EXPECT_LE(loop_facts.size(), 4U);
  EXPECT_EQ(std::string(loop_facts.back().device.data()), device.name());
  EXPECT_EQ(loop_facts.back().servo_rate_hz, 1000.0);
  EXPECT_EQ(loop_facts.back().max_torque_nm, 0.0F);
  EXPECT_NEAR(loop_facts.back().round_trip_s, 1e-9 * static_cast<double>(reply_delay_ns), 0.1e-9 * static_cast<double>(reply_delay_ns));
}

TEST_F(LoopReports, SayHowStronglyMotorsTurnTheStylus) {
  device.give_torque(0.25);
  make();
  join(kHaptics, NodeRole::haptics);
  run(3000);
  ASSERT_FALSE(loop_facts.empty());
  EXPECT_EQ(loop_facts.back().max_torque_nm, 0.25F);
}

TEST_F(LoopReports, AreNotSentToAHapticsNodeThatHasLeft) {
  make();
  join(kHaptics, NodeRole::haptics);
  run(3000);
  ASSERT_FALSE(loop_facts.empty());
  say(kHaptics, Bye{});
  run(10);
  loop_facts.clear();
  sequences.erase(kHaptics);
  run(3000);
  EXPECT_TRUE(loop_facts.empty());
}

}  // namespace
}  // namespace hapton
