#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <utility>

#include "core/math/float8.h"

namespace hapton {

// Where a builder of trees cuts a run of items in two: binned surface-area heuristic (MacDonald & Booth 1990; Wald 2007), for WideBvh and
// FdhTopology. RT: set-up only.

// An axis-aligned box in the first three lanes, empty until it is grown.
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
  // Of the next item. Pre: it is in the run.
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
constexpr int kCutBins = 16;  // as Wald 2007
using CutBins = std::array<CutBin, kCutBins>;

// The cheapest cut so far, between this bin and the next one.
struct BinnedCut {
  float cost = std::numeric_limits<float>::infinity();
  int axis = -1;  // none
  int bin = 0;

  // Takes a cut along this axis if it costs less. Either side has items. size: of all bins together.
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

  // The sides of the cut. Pre: bins are those of its axis; the items are in order, those of the right side from `middle` on.
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
