#include "core/collision/fdh_topology.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace hapton {
namespace {

FdhItem item_at(float x, float y, float z, float size, std::uint32_t id) { return {{x, y, z}, id, {x + size, y + size, z + size}}; }

// Expects every item in exactly one leaf, children after their parents, and the depth that the topology states. Returns the depth.
int check_topology(const FdhTopology& topology, std::size_t count) {
  std::vector<int> times_in_order(count, 0);
  std::vector<int> times_in_leaves(count, 0);
  for (const std::uint32_t id : topology.order) ++times_in_order.at(id);
  std::vector<int> level(topology.nodes.size(), 0);
  if (!level.empty()) level[0] = 1;
  int deepest = 0;
  for (std::size_t n = 0; n < topology.nodes.size(); ++n) {
    deepest = std::max(deepest, level[n]);
    EXPECT_GT(level[n], 0) << "node " << n << " has no parent";
    for (const std::uint32_t child : topology.nodes[n]) {
      if (child == FdhTopology::kNothing) continue;
      if (FdhTopology::is_leaf(child)) {
        for (std::uint32_t i = 0; i < FdhTopology::leaf_count(child); ++i) ++times_in_leaves.at(FdhTopology::leaf_first(child) + i);
      } else {
        EXPECT_GT(child, n);
        level.at(child) = level[n] + 1;
      }
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    EXPECT_EQ(times_in_order[i], 1);
    EXPECT_EQ(times_in_leaves[i], 1);
  }
  EXPECT_EQ(deepest, topology.depth);
  EXPECT_LE(topology.depth, FdhTopology::kMaxDepth);
  return topology.depth;
}

TEST(FdhTopology, HoldsEveryItemOnce) {
  std::mt19937 random(11);
  std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
  for (const std::size_t count : {0U, 1U, 2U, 4U, 5U, 8U, 33U, 1000U, 20000U}) {
    std::vector<FdhItem> items;
    for (std::uint32_t i = 0; i < count; ++i) items.push_back(item_at(unit(random), unit(random), unit(random), 0.01F, i));
    check_topology(build_fdh_topology(items), count);
  }
}

// The heuristic must cut evenly spread items near the middle: a tree that splits off a few at a time is several times as deep, and slow.
TEST(FdhTopology, EvenlySpreadItemsMakeAShallowTree) {
  constexpr unsigned kSeed = 12;
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<float> unit(-1.0F, 1.0F);
  std::vector<FdhItem> items;
  for (std::uint32_t i = 0; i < 20000; ++i) items.push_back(item_at(unit(random), unit(random), unit(random), 0.01F, i));
  EXPECT_LE(check_topology(build_fdh_topology(items), items.size()), 8) << "seed " << kSeed << "; as wide as can be it has 5 levels";
}

TEST(FdhTopology, AllItemsInOnePlaceAreHalved) {
  std::vector<FdhItem> items;
  for (std::uint32_t i = 0; i < 5000; ++i) items.push_back(item_at(0.5F, 0.5F, 0.5F, 0.1F, i));
  EXPECT_LE(check_topology(build_fdh_topology(items), items.size()), 13);  // 5000 < 2^13
}

// Each item is half as far out as the one before: the heuristic splits them off one by one, and without halving the depth would be n / 7.
TEST(FdhTopology, DepthIsBoundedOnGeometricSeries) {
  std::vector<FdhItem> items;
  for (std::uint32_t i = 0; i < 40000; ++i) {
    const float x = std::pow(0.5F, static_cast<float>(i % 120));
    items.push_back(item_at(x, x * x, 0.0F, x * 1e-3F, i));
  }
  check_topology(build_fdh_topology(items), items.size());
}

}  // namespace
}  // namespace hapton
