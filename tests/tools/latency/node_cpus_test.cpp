#include "tools/latency/node_cpus.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

namespace hapton {
namespace {

TEST(NodeCpus, AreTwoDifferentOnesOrNone) {
  const NodeCpus one = find_one_cpu();
  const NodeCpus two = find_two_cpus();
  EXPECT_EQ(one.io, one.haptics);
  EXPECT_EQ(one.are_shared(), one.io >= 0);
  EXPECT_FALSE(two.are_shared());
  EXPECT_EQ(two.haptics, one.haptics);
  EXPECT_EQ(two.io >= 0, std::thread::hardware_concurrency() >= 2 && two.haptics >= 0);
}

TEST(NodeCpus, AreTwoOnlyIfMedianAndTailAreShorterThere) {
  const TrialRun on_one{50.0, 90.0, 200.0};
  EXPECT_TRUE(should_use_two(on_one, {40.0, 80.0, 150.0}));
  EXPECT_TRUE(should_use_two(on_one, {40.0, 80.0, 250.0})) << "the longest of a short run is chance";
  EXPECT_FALSE(should_use_two(on_one, {40.0, 80.0, 1000.0}));
  EXPECT_FALSE(should_use_two(on_one, {40.0, 95.0, 150.0}));
  EXPECT_FALSE(should_use_two(on_one, {55.0, 80.0, 150.0}));
  EXPECT_FALSE(should_use_two(on_one, on_one));
  EXPECT_FALSE(should_use_two(on_one, {})) << "no round trips";
  EXPECT_TRUE(should_use_two({}, on_one)) << "no round trips on one";
}

TEST(NodeCpus, NodesThatShareACpuDoNotSpin) {
  using testing::ElementsAre;
  EXPECT_THAT(io_flags({1, 1}), ElementsAre("--cpu", "1", "--spin-reply", "0"));
  EXPECT_THAT(haptics_flags({1, 1}), ElementsAre("--cpu", "1", "--spin", "0"));
  EXPECT_THAT(io_flags({0, 1}), ElementsAre("--cpu", "0"));
  EXPECT_THAT(haptics_flags({0, 1}), ElementsAre("--cpu", "1"));
  EXPECT_THAT(io_flags({}), ElementsAre("--cpu", "-1"));
}

TEST(NodeCpus, TheChoiceIsExplained) {
  EXPECT_THAT(describe_choice({1, 1}, {50, 90, 200}, {40, 95, 150}), testing::StartsWith("io_node and haptics_node share CPU 1 ("));
  EXPECT_THAT(
      describe_choice({0, 1}, {50, 90, 200}, {40, 80, 150}),
      testing::AllOf(testing::StartsWith("io_node has CPU 0, haptics_node CPU 1 ("), testing::HasSubstr("on two 40, 80 and 150 us)")));
}

}  // namespace
}  // namespace hapton
