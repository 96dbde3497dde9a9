#include "io_node/loop_reporter.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/io_node/servo_fixture.h"

namespace hapton {
namespace {

struct LoopReports : Servos {
  std::vector<LoopFacts> facts;

  void SetUp() override {
    Servos::SetUp();
    endpoint.on_send = [this](const Address& to, const Datagram& datagram) {
      receive(to, datagram);
      if (const auto* one = std::get_if<LoopFacts>(&datagram.message)) {
        EXPECT_EQ(to, at(kHaptics));
        facts.push_back(*one);
      }
    };
  }
};

TEST_F(LoopReports, ComeOnceASecondWhenEnoughIsMeasured) {
  make();
  join(kHaptics, NodeRole::haptics);
  join(kVision, NodeRole::vision);
  run(static_cast<int>(LoopReporter::kLeastTrips) - 100);
  EXPECT_TRUE(facts.empty());
  run(3200);
  ASSERT_GE(facts.size(), 3U);
  EXPECT_LE(facts.size(), 4U);
  EXPECT_EQ(std::string(facts.back().device.data()), device.name());
  EXPECT_EQ(facts.back().servo_rate_hz, 1000.0);
  EXPECT_NEAR(facts.back().round_trip_s, 1e-9 * static_cast<double>(answer_delay_ns), 0.1e-9 * static_cast<double>(answer_delay_ns));
}

TEST_F(LoopReports, AreNotSentToAHapticsNodeThatHasLeft) {
  make();
  join(kHaptics, NodeRole::haptics);
  run(3000);
  ASSERT_FALSE(facts.empty());
  say(kHaptics, Bye{});
  run(10);
  facts.clear();
  sequences.erase(kHaptics);
  run(3000);
  EXPECT_TRUE(facts.empty());
}

}  // namespace
}  // namespace hapton
