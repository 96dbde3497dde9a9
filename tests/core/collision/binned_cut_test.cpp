#include "core/collision/binned_cut.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

namespace hapton {
namespace {

struct BinnedBox {
  FloatBox box;
  int bin = 0;
};

// Boxes in bins by their places along one axis, in the order of the bins. Some bins are empty.
std::vector<BinnedBox> boxes_in_bins(std::uint64_t seed, int count, int axis) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<float> unit(0.0F, 1.0F);
  std::vector<BinnedBox> items;
  for (int i = 0; i < count; ++i) {
    std::array<float, 3> low = {};
    for (float& x : low) x = unit(random) * unit(random);
    const float size = 0.2F * unit(random);
    items.push_back({.box = {Float4(low[0], low[1], low[2], 0.0F), Float4(low[0] + size, low[1] + size, low[2] + 2.0F * size, 0.0F)},
                     .bin = std::min(kCutBins - 1, static_cast<int>(low[static_cast<std::size_t>(axis)] * kCutBins))});
  }
  std::sort(items.begin(), items.end(), [](const BinnedBox& a, const BinnedBox& b) { return a.bin < b.bin; });
  return items;
}

CutBins bins_of(const std::vector<BinnedBox>& items) {
  CutBins bins;
  for (const BinnedBox& item : items) bins[static_cast<std::size_t>(item.bin)].add(item.box, item.box.twice_centre());
  return bins;
}

ItemRun run_of(const std::vector<BinnedBox>& items, std::uint32_t begin, std::uint32_t end) {
  ItemRun run{.begin = begin, .end = end};
  for (std::uint32_t i = begin; i < end; ++i) run.grow(items[i].box);
  return run;
}

void expect_equal(const FloatBox& a, const FloatBox& b) {
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(a.low[k], b.low[k]);
    EXPECT_EQ(a.high[k], b.high[k]);
  }
}

TEST(BinnedCut, IsTheCheapestOfAllWithItsSides) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(seed);
    const int count = seed % 3 == 0 ? 3 : 200;
    std::array<std::vector<BinnedBox>, 3> items;
    BinnedCut cut;
    float cheapest = std::numeric_limits<float>::infinity();
    int axis = -1;
    std::uint32_t middle = 0;
    for (int k = 0; k < 3; ++k) {
      std::vector<BinnedBox>& along = items[static_cast<std::size_t>(k)];
      along = boxes_in_bins(10 * seed + static_cast<std::uint64_t>(k), count, k);
      cut.consider(bins_of(along), k, static_cast<std::uint32_t>(count));
      for (std::uint32_t m = 1; m < along.size(); ++m) {
        if (along[m].bin == along[m - 1].bin) continue;
        const ItemRun left = run_of(along, 0, m);
        const ItemRun right = run_of(along, m, static_cast<std::uint32_t>(count));
        const float cost =
            left.box.half_area() * static_cast<float>(left.size()) + right.box.half_area() * static_cast<float>(right.size());
        if (!(cost < cheapest)) continue;
        cheapest = cost;
        axis = k;
        middle = m;
      }
    }
    EXPECT_EQ(cut.cost, cheapest);
    ASSERT_EQ(cut.axis, axis);
    if (axis < 0) continue;
    const std::vector<BinnedBox>& of_axis = items[static_cast<std::size_t>(axis)];
    EXPECT_LE(of_axis[middle - 1].bin, cut.bin);
    EXPECT_GT(of_axis[middle].bin, cut.bin);
    const auto all = static_cast<std::uint32_t>(count);
    const auto [left, right] = cut.sides(run_of(of_axis, 0, all), middle, bins_of(of_axis));
    const ItemRun expected[] = {run_of(of_axis, 0, middle), run_of(of_axis, middle, all)};
    EXPECT_EQ(left.size(), expected[0].size());
    EXPECT_EQ(right.size(), expected[1].size());
    expect_equal(left.box, expected[0].box);
    expect_equal(left.centres, expected[0].centres);
    expect_equal(right.box, expected[1].box);
    expect_equal(right.centres, expected[1].centres);
  }
}

TEST(BinnedCut, ThereIsNoneWhereAllAreInOneBin) {
  std::vector<BinnedBox> items = boxes_in_bins(1, 20, 0);
  for (BinnedBox& item : items) item.bin = 7;
  BinnedCut cut;
  cut.consider(bins_of(items), 0, 20);
  EXPECT_EQ(cut.axis, -1);
}

TEST(BinnedCut, JoinedBinsAreTheBinOfAllTheirItems) {
  const std::vector<BinnedBox> items = boxes_in_bins(2, 40, 1);
  CutBin first, last, all;
  for (std::size_t i = 0; i < items.size(); ++i) {
    (i % 2 == 0 ? first : last).add(items[i].box, items[i].box.twice_centre());
    all.add(items[i].box, items[i].box.twice_centre());
  }
  first.join(last);
  EXPECT_EQ(first.count, all.count);
  expect_equal(first.box, all.box);
  expect_equal(first.centres, all.centres);
}

}  // namespace
}  // namespace hapton
