#include "core/tool/feature_set.h"

#include <gtest/gtest.h>

#include <random>
#include <set>
#include <tuple>

namespace hapton {
namespace {

TEST(FeatureSet, HoldsWhatASetOfTheNumbersHolds) {
  constexpr unsigned kSeed = 12;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937 random(kSeed);
  const auto draw_below = [&](std::uint32_t n) { return static_cast<std::uint32_t>(random() % n); };
  constexpr std::size_t kMax = 1000;
  FeatureSet set(kMax);
  for (int run = 0; run < 5; ++run) {
    std::set<std::tuple<std::uint32_t, std::uint32_t, FeaturePair::Kind, int, int>> reference;
    while (reference.size() < kMax) {
      FeaturePair pair;
      pair.tool_triangle = draw_below(40);
      pair.scene_triangle = draw_below(20) | draw_below(2) << 31;
      pair.kind = static_cast<FeaturePair::Kind>(draw_below(3));
      pair.tool_corner = static_cast<int>(draw_below(3));
      pair.scene_corner = static_cast<int>(draw_below(3));
      const bool is_new =
          reference.insert({pair.tool_triangle, pair.scene_triangle, pair.kind, pair.tool_corner, pair.scene_corner}).second;
      ASSERT_EQ(set.has(pair), !is_new);
      ASSERT_EQ(set.insert(pair), is_new);
      ASSERT_TRUE(set.has(pair));
    }
    set.clear();
  }
}

}  // namespace
}  // namespace hapton
