#include "core/geometry/disjoint_sets.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace hapton {
namespace {

// The twin: a label for each number, rewritten at every join.
TEST(DisjointSets, AgreeWithLabels) {
  constexpr std::uint64_t kSetsSeed = 20261122;
  constexpr std::uint32_t kNumbers = 300;
  std::mt19937_64 random(kSetsSeed);
  DisjointSets sets(kNumbers);
  std::vector<std::uint32_t> labels(kNumbers);
  std::iota(labels.begin(), labels.end(), 0U);
  for (int k = 0; k < 280; ++k) {
    const auto a = static_cast<std::uint32_t>(random() % kNumbers);
    const auto b = static_cast<std::uint32_t>(random() % kNumbers);
    sets.join(a, b);
    const std::uint32_t low = std::min(labels[a], labels[b]);
    const std::uint32_t high = std::max(labels[a], labels[b]);
    for (std::uint32_t& label : labels) label = label == high ? low : label;
    for (std::uint32_t i = 0; i < kNumbers; ++i) ASSERT_EQ(sets.root(i), labels[i]) << "join " << k << ", seed " << kSetsSeed;
  }
}

}  // namespace
}  // namespace hapton
