#include "vision_node/detail_choice.h"

#include <vector>

#include <gtest/gtest.h>

namespace hapton {
namespace {

const std::vector<LevelFacts> kLevels = {{1'000'000, 0.0}, {250'000, 1e-5}, {60'000, 1e-4}, {15'000, 1e-3}};
constexpr std::size_t kNoLimit = 10'000'000;

TEST(DetailChoice, TakesTheCoarsestWhoseErrorIsNotSeen) {
  EXPECT_EQ(choose_level(kLevels, 10.0, kNoLimit), 3U);    // level 3: 0.01 pixels
  EXPECT_EQ(choose_level(kLevels, 1000.0, kNoLimit), 2U);  // level 3: 1 pixel; level 2: 0.1 pixels
  EXPECT_EQ(choose_level(kLevels, 1e4, kNoLimit), 1U);
  EXPECT_EQ(choose_level(kLevels, 1e6, kNoLimit), 0U) << "nearer than any level is good for: the mesh itself";
}

TEST(DetailChoice, StaysWithinTheBudgetWhereSomethingDoes) {
  EXPECT_EQ(choose_level(kLevels, 1e6, 100'000), 2U);
  EXPECT_EQ(choose_level(kLevels, 1e6, 60'000), 2U);
  EXPECT_EQ(choose_level(kLevels, 1e6, 1'000), 3U);
  EXPECT_EQ(choose_level(kLevels, 10.0, 100'000), 3U) << "a budget is no reason to draw more than is seen";
}

TEST(DetailChoice, AMeshWithoutLevelsIsDrawnAsItIs) {
  const std::vector<LevelFacts> alone = {{1'000'000, 0.0}};
  EXPECT_EQ(choose_level(alone, 1e6, 10), 0U);
}

}  // namespace
}  // namespace hapton
