#include "core/collision/fdh_topology.h"

#include <algorithm>
#include <bit>
#include <limits>

namespace hapton {
namespace {

using Lanes = float __attribute__((vector_size(16)));
using IntLanes = std::int32_t __attribute__((vector_size(16)));

constexpr int kBins = 16;  // as Wald 2007
// Runs of this size and more are split along their widest axis only: a third of the work, and nearly always the same choice.
constexpr std::uint32_t kOneAxisFrom = 2048;
// In the unit of the mesh, and a 1e-15th of the smallest mesh that a tree accepts. Below it the bins' scale (kBins over the extent) would
// approach a float's largest number, 3.4e38, and a split gains nothing.
constexpr float kSmallestExtent = 1e-30F;
// An axis thinner than this share of the widest is not worth a split: its centroids, each rounded to 2^-24 of the widest, have four bits
// there.
constexpr float kThinnestShare = 1e-6F;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

Lanes lane_min(const Lanes& a, const Lanes& b) { return a < b ? a : b; }
Lanes lane_max(const Lanes& a, const Lanes& b) { return a > b ? a : b; }

struct Box {
  Lanes low = {kInfinity, kInfinity, kInfinity, kInfinity};
  Lanes high = {-kInfinity, -kInfinity, -kInfinity, -kInfinity};

  void grow(const Box& other) {
    low = lane_min(low, other.low);
    high = lane_max(high, other.high);
  }
  void grow(const Lanes& point) {
    low = lane_min(low, point);
    high = lane_max(high, point);
  }
  float half_area() const {
    const Lanes d = high - low;
    return d[0] * d[1] + d[1] * d[2] + d[2] * d[0];
  }
};

Box box_of(const FdhItem& item) {
  Box box;
  box.low = Lanes{item.low[0], item.low[1], item.low[2], 0.0F};
  box.high = Lanes{item.high[0], item.high[1], item.high[2], 0.0F};
  return box;
}
// Twice the centre.
Lanes centre_of(const Box& box) { return box.low + box.high; }

struct Range {
  std::uint32_t begin = 0;
  std::uint32_t end = 0;
  Box box;
  Box centres;
  std::uint32_t size() const { return end - begin; }
};

struct Bin {
  Box box;
  Box centres;
  std::uint32_t count = 0;
};

struct Builder {
  std::span<FdhItem> items;
  FdhTopology out;

  Range range_of(std::uint32_t begin, std::uint32_t end) const {
    Range range{begin, end, {}, {}};
    for (std::uint32_t i = begin; i < end; ++i) {
      const Box box = box_of(items[i]);
      range.box.grow(box);
      range.centres.grow(centre_of(box));
    }
    return range;
  }

  std::pair<Range, Range> halve(const Range& range, int axis) {
    const std::uint32_t middle = range.begin + range.size() / 2;
    std::nth_element(items.begin() + range.begin, items.begin() + middle, items.begin() + range.end,
                     [axis](const FdhItem& a, const FdhItem& b) { return a.low[axis] + a.high[axis] < b.low[axis] + b.high[axis]; });
    return {range_of(range.begin, middle), range_of(middle, range.end)};
  }

  struct Cut {
    float cost = kInfinity;
    int axis = -1;
    int bin = 0;
  };

  static void find_cut(const std::array<Bin, kBins>& bins, int axis, Cut& best) {
    std::array<float, kBins> right = {};
    Box box;
    std::uint32_t count = 0;
    for (int b = kBins - 1; b > 0; --b) {
      box.grow(bins[b].box);
      count += bins[b].count;
      right[b] = count > 0 ? box.half_area() * static_cast<float>(count) : -1.0F;
    }
    box = {};
    count = 0;
    for (int b = 0; b + 1 < kBins; ++b) {
      box.grow(bins[b].box);
      count += bins[b].count;
      if (count == 0 || right[b + 1] < 0.0F) continue;
      const float cost = box.half_area() * static_cast<float>(count) + right[b + 1];
      if (cost < best.cost) best = {cost, axis, b};
    }
  }

  std::pair<Range, Range> split(const Range& range, bool must_halve) {
    const Lanes extent = range.centres.high - range.centres.low;
    int widest = 0;
    for (int k = 1; k < 3; ++k) {
      if (extent[k] > extent[widest]) widest = k;
    }
    if (must_halve || !(extent[widest] > kSmallestExtent)) return halve(range, widest);

    Lanes scale = {};
    for (int k = 0; k < 3; ++k)
      scale[k] = extent[k] > extent[widest] * kThinnestShare ? static_cast<float>(kBins) * 0.999F / extent[k] : 0.0F;
    const Lanes base = range.centres.low;
    const auto bins_of = [&](const Lanes& centre) { return __builtin_convertvector((centre - base) * scale, IntLanes); };

    std::array<std::array<Bin, kBins>, 3> bins;
    const bool one_axis = range.size() >= kOneAxisFrom;
    const int first = one_axis ? widest : 0;
    const int last = one_axis ? widest : 2;
    for (std::uint32_t i = range.begin; i < range.end; ++i) {
      const Box box = box_of(items[i]);
      const Lanes centre = centre_of(box);
      const IntLanes b = bins_of(centre);
      for (int k = first; k <= last; ++k) {
        Bin& bin = bins[k][static_cast<std::size_t>(b[k])];
        bin.box.grow(box);
        bin.centres.grow(centre);
        ++bin.count;
      }
    }
    Cut cut;
    for (int k = first; k <= last; ++k) find_cut(bins[k], k, cut);
    if (cut.axis < 0) return halve(range, widest);

    const auto middle = std::partition(items.begin() + range.begin, items.begin() + range.end,
                                       [&](const FdhItem& item) { return bins_of(centre_of(box_of(item)))[cut.axis] <= cut.bin; });
    const auto m = static_cast<std::uint32_t>(middle - items.begin());
    Range left{range.begin, m, {}, {}};
    Range right{m, range.end, {}, {}};
    for (int b = 0; b < kBins; ++b) {
      Range& side = b <= cut.bin ? left : right;
      side.box.grow(bins[cut.axis][b].box);
      side.centres.grow(bins[cut.axis][b].centres);
    }
    return {left, right};
  }

  // Makes the node of a range of more than one leaf. Recursion: at most kMaxDepth deep.
  std::uint32_t make_node(const Range& whole, int level) {
    const auto index = static_cast<std::uint32_t>(out.nodes.size());
    FdhTopology::Children nothing;
    nothing.fill(FdhTopology::kNothing);
    out.nodes.push_back(nothing);
    out.depth = std::max(out.depth, level);
    // Halving reduces ceil(log2 n) = bit_width(n - 1) by one per level, so once that equals the levels left, halving ends in time; any
    // other split leaves it unchanged at worst. At the root 28 <= kMaxDepth - 1, so it holds at every node.
    const int levels_left = FdhTopology::kMaxDepth - level;
    const bool must_halve = static_cast<int>(std::bit_width(whole.size() - 1)) >= levels_left;

    std::array<Range, FdhTopology::kWidth> parts;
    parts[0] = whole;
    int count = 1;
    while (count < FdhTopology::kWidth) {
      int widest = -1;
      float largest = -1.0F;
      for (int i = 0; i < count; ++i) {
        if (parts[i].size() <= FdhTopology::kLeafSize) continue;
        const float area = parts[i].box.half_area();
        if (widest < 0 || area > largest) {
          widest = i;
          largest = area;
        }
      }
      if (widest < 0) break;
      const auto [left, right] = split(parts[widest], must_halve);
      parts[widest] = left;
      parts[count++] = right;
    }
    for (int i = 0; i < count; ++i) {
      const std::uint32_t child =
          parts[i].size() <= FdhTopology::kLeafSize ? FdhTopology::leaf(parts[i].begin, parts[i].size()) : make_node(parts[i], level + 1);
      out.nodes[index][i] = child;
    }
    return index;
  }
};

}  // namespace

FdhTopology build_fdh_topology(std::span<FdhItem> items) {
  Builder builder{items, {}};
  const auto n = static_cast<std::uint32_t>(items.size());
  if (n > 0) {
    builder.out.nodes.reserve(n / 6 + 8);
    if (n <= FdhTopology::kLeafSize) {
      FdhTopology::Children only;
      only.fill(FdhTopology::kNothing);
      only[0] = FdhTopology::leaf(0, n);
      builder.out.nodes.push_back(only);
      builder.out.depth = 1;
    } else {
      builder.make_node(builder.range_of(0, n), 1);
    }
  }
  builder.out.order.resize(n);
  for (std::uint32_t i = 0; i < n; ++i) builder.out.order[i] = items[i].id;
  return std::move(builder.out);
}

}  // namespace hapton
