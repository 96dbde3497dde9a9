#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <utility>

#include "core/math/float8.h"

namespace hapton {

// Finds where a tree builder cuts a run of items in two: binned surface-area heuristic (MacDonald & Booth 1990; Wald 2007), for WideBvh and
// FdhTopology. RT: set-up only.

// An axis-aligned box, x, y and z in the first three lanes; empty until it is grown.
struct FloatBox {
  Float4 low = Float4(std::numeric_limits<float>::infinity());
  Float4 high = Float4(-std::numeric_limits<float>::infinity());

  void grow(const FloatBox& other) {
    low = min(low, other.low);
    high = max(high, other.high);
  }
  Float4 twice_centre() const { return low + high; }
  float half_area() const {
    const Float4 d = high - low;
    return d[0] * d[1] + d[1] * d[2] + d[2] * d[0];
  }
};

// A run of items with its box and the box of its (doubled) centres.
struct ItemRun {
  std::uint32_t begin = 0;
  std::uint32_t end = 0;
  FloatBox box = {};
  FloatBox centres = {};

  std::uint32_t size() const { return end - begin; }
  // Grows the boxes by one item of the run.
  void grow(const FloatBox& item) {
    box.grow(item);
    const Float4 centre = item.twice_centre();
    centres.grow({centre, centre});
  }
};

// The items whose centres are in one of the equal parts of an axis.
struct CutBin {
  FloatBox box;
  FloatBox centres;
  std::uint32_t count = 0;

  void add(const FloatBox& item, const Float4& centre) {
    box.grow(item);
    centres.grow({centre, centre});
    ++count;
  }
  void join(const CutBin& other) {
    box.grow(other.box);
    centres.grow(other.centres);
    count += other.count;
  }
};
constexpr int kCutBins = 16;  // as in Wald 2007
using CutBins = std::array<CutBin, kCutBins>;

// The cheapest cut found so far: across `axis`, between the bins `bin` and `bin` + 1.
struct BinnedCut {
  float cost = std::numeric_limits<float>::infinity();
  int axis = -1;  // no cut found yet
  int bin = 0;

  // Takes the best cut across the axis `along` if it costs less. Both sides of a cut have items. size: number of items in all bins.
  void consider(const CutBins& bins, int along, std::uint32_t size) {
    std::array<float, kCutBins> right_cost = {};
    FloatBox box;
    std::uint32_t count = 0;
    for (int b = kCutBins - 1; b > 0; --b) {
      box.grow(bins[b].box);
      count += bins[b].count;
      right_cost[b] = count > 0 ? box.half_area() * static_cast<float>(count) : 0.0F;
    }
    box = {};
    count = 0;
    BinnedCut best = *this;
    for (int b = 0; b + 1 < kCutBins; ++b) {
      box.grow(bins[b].box);
      count += bins[b].count;
      if (count == 0 || count == size) continue;
      const float both = box.half_area() * static_cast<float>(count) + right_cost[b + 1];
      if (both < best.cost) best = {both, along, b};
    }
    *this = best;
  }

  // The two sides of the cut. Pre: `bins` are those of the cut's axis; the items of the right side have been moved to `middle` and beyond.
  std::pair<ItemRun, ItemRun> sides(const ItemRun& run, std::uint32_t middle, const CutBins& bins) const {
    ItemRun left{.begin = run.begin, .end = middle};
    ItemRun right{.begin = middle, .end = run.end};
    for (int b = 0; b < kCutBins; ++b) {
      ItemRun& side = b <= bin ? left : right;
      side.box.grow(bins[b].box);
      side.centres.grow(bins[b].centres);
    }
    return {left, right};
  }
};

}  // namespace hapton
