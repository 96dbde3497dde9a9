#include "haptics_node/haptics_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(HapticsReport, TimesSayTheWorstStepAndTheTail) {
  LatencyHistogram times;
  for (int i = 0; i < 9980; ++i) times.record(1'000);
  for (int i = 0; i < 19; ++i) times.record(50'000);
  times.record(1'250'000);
  const std::string text = describe_times("step", times);
  EXPECT_THAT(text, testing::StartsWith("step: p50 1.0"));
  EXPECT_THAT(text, testing::ContainsRegex("p99.9 (49|50)\\."));
  EXPECT_THAT(text, testing::HasSubstr("worst 1250.00, n 10000"));
}

TEST(HapticsReport, NothingMeasuredIsNoLine) { EXPECT_EQ(describe_times("step", LatencyHistogram()), ""); }

}  // namespace
}  // namespace hapton
