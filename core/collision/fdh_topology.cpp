#include "core/collision/fdh_topology.h"

#include <algorithm>
#include <bit>
#include <utility>

#include "core/collision/binned_cut.h"

namespace hapton {
namespace {

// Ranges of this many items and more are split only along their widest axis: a third of the work, and nearly always the same cut.
constexpr std::uint32_t kOneAxisFrom = 2048;
// In the unit of the mesh: 1e-15 times the smallest extent of a mesh that a tree accepts. With a smaller extent of the centres, the scale
// of the bins (kCutBins / extent) would approach the largest float, 3.4e38, and a split gains nothing.
constexpr float kSmallestExtent = 1e-30F;
// An axis along which the centres extend by less than this share of the widest extent is not worth a split: the centres, each rounded to
// 2^-24 of the widest extent, have only four bits along that axis.
constexpr float kThinnestShare = 1e-6F;

FloatBox box_of(const FdhItem& item) {
  return {Float4(item.low[0], item.low[1], item.low[2], 0.0F), Float4(item.high[0], item.high[1], item.high[2], 0.0F)};
}

struct Builder {
  std::span<FdhItem> items;
  FdhTopology topology;

  ItemRun range_of(std::uint32_t begin, std::uint32_t end) const {
    ItemRun range{.begin = begin, .end = end};
    for (std::uint32_t i = begin; i < end; ++i) range.grow(box_of(items[i]));
    return range;
  }

  std::pair<ItemRun, ItemRun> halve(const ItemRun& range, int axis) {
    const std::uint32_t middle = range.begin + range.size() / 2;
    std::nth_element(items.begin() + range.begin, items.begin() + middle, items.begin() + range.end,
                     [axis](const FdhItem& a, const FdhItem& b) { return a.low[axis] + a.high[axis] < b.low[axis] + b.high[axis]; });
    return {range_of(range.begin, middle), range_of(middle, range.end)};
  }

  std::pair<ItemRun, ItemRun> split(const ItemRun& range, bool must_halve) {
    alignas(16) std::array<float, 4> extent;
    store(extent.data(), range.centres.high - range.centres.low);
    int widest = 0;
    for (int k = 1; k < 3; ++k) {
      if (extent[k] > extent[widest]) widest = k;
    }
    if (must_halve || !(extent[widest] > kSmallestExtent)) return halve(range, widest);

    std::array<float, 4> scale = {};
    for (int k = 0; k < 3; ++k) {
      if (extent[k] > extent[widest] * kThinnestShare) scale[k] = kCutBins * 0.999F / extent[k];
    }
    const Float4 base = range.centres.low;
    const Float4 scales = Float4::load_unaligned(scale.data());
    const auto bins_of = [&](const Float4& centre) { return Int4::truncated((centre - base) * scales); };

    std::array<CutBins, 3> bins;
    const bool one_axis = range.size() >= kOneAxisFrom;
    const int first = one_axis ? widest : 0;
    const int last = one_axis ? widest : 2;
    for (std::uint32_t i = range.begin; i < range.end; ++i) {
      const FloatBox box = box_of(items[i]);
      const Float4 centre = box.twice_centre();
      alignas(16) std::array<std::int32_t, 4> b;
      store(b.data(), bins_of(centre));
      for (int k = first; k <= last; ++k) bins[k][static_cast<std::size_t>(b[k])].add(box, centre);
    }
    BinnedCut cut;
    for (int k = first; k <= last; ++k) cut.consider(bins[k], k, range.size());
    if (cut.axis < 0) return halve(range, widest);

    const Int4 last_before = Int4(cut.bin);
    const auto middle = std::partition(items.begin() + range.begin, items.begin() + range.end, [&](const FdhItem& item) {
      return (sign_bits(bins_of(box_of(item).twice_centre()) > last_before) >> cut.axis & 1U) == 0;
    });
    return cut.sides(range, static_cast<std::uint32_t>(middle - items.begin()), bins[cut.axis]);
  }

  // Makes the node of a range that does not fit into one leaf. Recursion: at most kMaxDepth deep.
  std::uint32_t make_node(const ItemRun& whole, int level) {
    const auto index = static_cast<std::uint32_t>(topology.nodes.size());
    FdhTopology::Children nothing;
    nothing.fill(FdhTopology::kNothing);
    topology.nodes.push_back(nothing);
    topology.depth = std::max(topology.depth, level);
    // Halving reduces ceil(log2 n) = bit_width(n - 1) by at least one per level, so it ends in time if it begins when this number is the
    // levels left. Other splits do not increase the number. At the root it is at most 28 <= kMaxDepth - 1, so it never exceeds them.
    const int levels_left = FdhTopology::kMaxDepth - level;
    const bool must_halve = static_cast<int>(std::bit_width(whole.size() - 1)) >= levels_left;

    std::array<ItemRun, FdhTopology::kWidth> parts;
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
      topology.nodes[index][i] = child;
    }
    return index;
  }
};

}  // namespace

FdhTopology build_fdh_topology(std::span<FdhItem> items) {
  Builder builder{items, {}};
  const auto n = static_cast<std::uint32_t>(items.size());
  if (n > 0) {
    builder.topology.nodes.reserve(n / 6 + 8);
    if (n <= FdhTopology::kLeafSize) {
      FdhTopology::Children only;
      only.fill(FdhTopology::kNothing);
      only[0] = FdhTopology::leaf(0, n);
      builder.topology.nodes.push_back(only);
      builder.topology.depth = 1;
    } else {
      builder.make_node(builder.range_of(0, n), 1);
    }
  }
  builder.topology.order.resize(n);
  for (std::uint32_t i = 0; i < n; ++i) builder.topology.order[i] = items[i].id;
  return std::move(builder.topology);
}

}  // namespace hapton
