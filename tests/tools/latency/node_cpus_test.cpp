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
  EXPECT_TRUE(should_use_two({50.0, 90.0}, {40.0, 80.0}));
  EXPECT_FALSE(should_use_two({50.0, 90.0}, {40.0, 95.0}));
  EXPECT_FALSE(should_use_two({50.0, 90.0}, {55.0, 80.0}));
  EXPECT_FALSE(should_use_two({50.0, 90.0}, {50.0, 90.0}));
  EXPECT_FALSE(should_use_two({50.0, 90.0}, {})) << "no round trips";
}

TEST(NodeCpus, TheChoiceIsExplained) {
  EXPECT_THAT(describe_choice({1, 1}, {50, 90}, {40, 95}), testing::StartsWith("io_node and haptics_node share CPU 1 ("));
  EXPECT_THAT(describe_choice({0, 1}, {50, 90}, {40, 80}),
              testing::AllOf(testing::StartsWith("io_node has CPU 0, haptics_node CPU 1 ("), testing::HasSubstr("on two 40 and 80 us)")));
}

}  // namespace
}  // namespace hapton
