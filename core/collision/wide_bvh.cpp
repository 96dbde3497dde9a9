#include "core/collision/wide_bvh.h"

#include <algorithm>
#include <numeric>

#include "core/collision/binned_cut.h"

namespace hapton {
namespace {

// An item's box. The unused fourth lane of `low` holds the item's number, encoded so that it is never subnormal and so not slow to add.
struct Item {
  static constexpr std::uint32_t kNotSubnormal = 0x40000000U;
  FloatBox box;
  std::uint32_t id() const { return last_word(box.low) ^ kNotSubnormal; }
  Float4 twice_centre() const { return box.twice_centre(); }
  float twice_centre(int axis) const { return box.low[axis] + box.high[axis]; }
};

Item make_item(const Box& box, std::uint32_t id) {
  Item item;
  item.box.low = Float4(detail::round_down(box.low[0]), detail::round_down(box.low[1]), detail::round_down(box.low[2]), 0.0F);
  item.box.high = Float4(detail::round_up(box.high[0]), detail::round_up(box.high[1]), detail::round_up(box.high[2]), 0.0F);
  item.box.low = with_last_word(item.box.low, id ^ Item::kNotSubnormal);
  return item;
}

constexpr std::uint32_t kTwoLevelItems = 64;  // items that fill a whole level of eight nodes
static_assert(kTwoLevelItems == WideBvh::kWidth * WideBvh::kWidth);
// In larger runs only the widest axis is tried: it is nearly always the best, and this takes a third of the work.
constexpr std::uint32_t kOneAxisAbove = 512;

}  // namespace

struct WideBvh::Builder {
  LargeVector<Item> items;
  LargeVector<Node>& nodes;
  int depth = 0;

  ItemRun range_of(std::uint32_t begin, std::uint32_t end) const {
    ItemRun range{.begin = begin, .end = end};
    for (std::uint32_t i = begin; i < end; ++i) range.grow(items[i].box);
    return range;
  }

  // Splits off the first `count` items along the axis, which bounds the depth for any geometry.
  std::pair<ItemRun, ItemRun> split_off(const ItemRun& range, int axis, std::uint32_t count) {
    const std::uint32_t middle = range.begin + count;
    if (range.size() <= kTwoLevelItems) {
      partition_few(range, axis, count);
      return {range_of(range.begin, middle), range_of(middle, range.end)};
    }
    std::nth_element(items.begin() + range.begin, items.begin() + middle, items.begin() + range.end,
                     [axis](const Item& a, const Item& b) { return a.twice_centre(axis) < b.twice_centre(axis); });
    return {range_of(range.begin, middle), range_of(middle, range.end)};
  }

  // Moves the `count` items that come first along the axis in front of the others; within both groups the order stays as it is. Each item's
  // rank is counted with eight comparisons at a time, without branches.
  void partition_few(const ItemRun& range, int axis, std::uint32_t count) {
    alignas(32) std::array<float, kTwoLevelItems> centres;
    centres.fill(std::numeric_limits<float>::infinity());
    const std::uint32_t size = range.size();
    for (std::uint32_t i = 0; i < size; ++i) centres[i] = items[range.begin + i].twice_centre(axis);
    std::array<std::uint32_t, kTwoLevelItems> before;  // for each item, how many come before it
    std::uint32_t candidates = 0;
    float last = std::numeric_limits<float>::lowest();  // largest centre of the items with fewer than `count` before them
    for (std::uint32_t i = 0; i < size; ++i) {
      const Float8 own = Float8(centres[i]);
      Uint32x8 less = Uint32x8(0U);
      for (std::uint32_t j = 0; j < size; j += 8) {
        less = less + as_words(Float8::load(&centres[j]) < own);
      }
      before[i] = 0U - sum(less);  // a comparison that holds adds -1
      candidates += before[i] < count ? 1 : 0;
      last = before[i] < count ? std::max(last, centres[i]) : last;
    }
    std::uint32_t surplus = candidates - count;  // so many items at `last` belong to the others
    std::array<Item, kTwoLevelItems> others;
    std::uint32_t at = range.begin;
    std::uint32_t other = 0;
    for (std::uint32_t i = 0; i < size; ++i) {
      const Item item = items[range.begin + i];
      bool is_first = before[i] < count;
      if (surplus > 0 && is_first && centres[i] == last) {
        is_first = false;
        --surplus;
      }
      others[other] = item;
      items[at] = item;
      at += is_first ? 1 : 0;
      other += is_first ? 0 : 1;
    }
    std::copy_n(others.begin(), other, items.begin() + at);
  }

  // The bin of a centre along each axis: along all axes, kCutBins bins divide the extent of the centres.
  struct Binning {
    Float4 base;
    Float4 scale;

    Int4 bins_of(const Float4& centre) const { return max(Int4(0), min(Int4::truncated((centre - base) * scale), Int4(kCutBins - 1))); }
  };

  static Binning binning_of(const ItemRun& range, const std::array<float, 4>& extent) {
    std::array<float, 4> scale = {};
    for (int k = 0; k < 3; ++k) scale[k] = extent[k] > 0.0F ? kCutBins * 0.999F / extent[k] : 0.0F;
    return {range.centres.low, Float4::load_unaligned(scale.data())};
  }

  // Fills the bins in one pass. widest: the only axis to fill; -1: all three.
  void fill_bins(const ItemRun& range, const Binning& binning, int widest, std::array<CutBins, 3>& bins) const {
    for (std::uint32_t i = range.begin; i < range.end; ++i) {
      const Float4 centre = items[i].twice_centre();
      alignas(16) std::array<std::int32_t, 4> b;
      store(b.data(), binning.bins_of(centre));
      if (widest >= 0) {
        // Successive items often fall into one bin: three sets of bins, so that successive additions do not wait for each other.
        bins[i % 3][b[widest]].add(items[i].box, centre);
      } else {
        for (int k = 0; k < 3; ++k) bins[k][b[k]].add(items[i].box, centre);
      }
    }
    if (widest < 0) return;
    for (int bin = 0; bin < kCutBins; ++bin) {
      for (int k = 0; k < 3; ++k) {
        if (k != widest) bins[widest][bin].join(bins[k][bin]);
      }
    }
  }

  // Works without a branch, which would be mispredicted half of the time: each item is swapped with the first one that does not come before
  // the cut. bins: those of the cut's axis.
  std::pair<ItemRun, ItemRun> partition_at(const BinnedCut& cut, const ItemRun& range, const Binning& binning, const CutBins& bins) {
    std::uint32_t at = range.begin;
    const Int4 last = Int4(cut.bin);
    for (std::uint32_t i = range.begin; i < range.end; ++i) {
      const Int4 beyond = binning.bins_of(items[i].twice_centre()) > last;
      const auto is_before = ~sign_bits(beyond) >> cut.axis & 1U;
      std::swap(items[i], items[at]);
      at += is_before;
    }
    return cut.sides(range, at, bins);
  }

  std::pair<ItemRun, ItemRun> split(const ItemRun& range, bool is_balanced) {
    alignas(16) std::array<float, 4> extent;
    store(extent.data(), range.centres.high - range.centres.low);
    const int widest = static_cast<int>(std::max_element(extent.begin(), extent.begin() + 3) - extent.begin());
    const std::uint32_t half = range.size() / 2;
    // A run that fits into eight nodes is cut at a multiple of kWidth items: fewer nodes, and no worse for items of similar size.
    if (range.size() <= kTwoLevelItems) return split_off(range, widest, (half + kWidth - 1) / kWidth * kWidth);
    if (is_balanced || !(extent[widest] > 0.0F) || !std::isfinite(extent[widest])) return split_off(range, widest, half);
    const bool one_axis = range.size() > kOneAxisAbove;
    const Binning binning = binning_of(range, extent);
    std::array<CutBins, 3> bins;
    fill_bins(range, binning, one_axis ? widest : -1, bins);
    BinnedCut cut;
    for (int k = one_axis ? widest : 0; k <= (one_axis ? widest : 2); ++k) {
      if (extent[k] > 0.0F) cut.consider(bins[k], k, range.size());
    }
    if (cut.axis < 0) return split_off(range, widest, half);
    return partition_at(cut, range, binning, bins[cut.axis]);
  }

  void store_child(Node& node, int c, const FloatBox& box, std::uint32_t child) {
    alignas(16) std::array<float, 4> low;
    alignas(16) std::array<float, 4> high;
    store(low.data(), box.low);
    store(high.data(), box.high);
    for (int k = 0; k < 3; ++k) {
      node.low[k][c] = low[k];
      node.high[k][c] = high[k];
    }
    node.child[c] = child;
  }

  // Builds the node of a run and returns its number. Splits the child with the largest expected cost until there are eight.
  std::uint32_t build(const ItemRun& range, int level) {
    const auto index = static_cast<std::uint32_t>(nodes.size());
    nodes.emplace_back();
    for (int k = 0; k < 3; ++k) {
      nodes[index].low[k].fill(std::numeric_limits<float>::infinity());
      nodes[index].high[k].fill(-std::numeric_limits<float>::infinity());
    }
    nodes[index].child.fill(0);
    depth = std::max(depth, level);

    if (range.size() <= kWidth) {
      for (std::uint32_t i = range.begin; i < range.end; ++i) {
        store_child(nodes[index], static_cast<int>(i - range.begin), items[i].box, items[i].id() | kItemBit);
      }
      return index;
    }
    // Below this level runs are halved by count: 13 levels of eight-fold division cover 2^32 items, well inside kMaxDepth.
    const bool is_balanced = level > kMaxDepth - 14;
    std::array<ItemRun, kWidth> parts;
    parts[0] = range;
    int count = 1;
    while (count < kWidth) {
      int largest = -1;
      float cost = -1.0F;
      for (int c = 0; c < count; ++c) {
        if (parts[c].size() <= kWidth) continue;
        const float part_cost =
            is_balanced ? static_cast<float>(parts[c].size()) : parts[c].box.half_area() * static_cast<float>(parts[c].size());
        if (part_cost > cost) {
          cost = part_cost;
          largest = c;
        }
      }
      if (largest < 0) break;
      const auto [left, right] = split(parts[largest], is_balanced);
      parts[largest] = left;
      parts[count++] = right;
    }
    for (int c = 0; c < count; ++c) {
      const std::uint32_t child = parts[c].size() == 1 ? items[parts[c].begin].id() | kItemBit : build(parts[c], level + 1);
      store_child(nodes[index], c, parts[c].box, child);
    }
    return index;
  }
};

WideBvh::WideBvh(std::span<const Box> boxes) : WideBvh(boxes.size(), [&](std::size_t i) { return boxes[i]; }) {}

WideBvh::WideBvh(std::size_t count, const std::function<Box(std::size_t)>& box_of) {
  if (count == 0) return;
  Builder builder{.items = {}, .nodes = nodes_};
  builder.items.reserve(count);
  for (std::size_t i = 0; i < count; ++i) builder.items.push_back(make_item(box_of(i), static_cast<std::uint32_t>(i)));
  nodes_.reserve(count / 6 + 1);  // usually enough: moving the nodes would cost more than the unused rest
  builder.build(builder.range_of(0, static_cast<std::uint32_t>(count)), 1);
  if (nodes_.capacity() > nodes_.size() + nodes_.size() / 16) nodes_.shrink_to_fit();
  depth_ = builder.depth;
}

LargeVector<std::uint32_t> WideBvh::items_in_tree_order() const {
  LargeVector<std::uint32_t> order;
  std::vector<std::uint32_t> stack;
  if (!nodes_.empty()) stack.push_back(0);
  while (!stack.empty()) {
    const std::uint32_t ref = stack.back();
    stack.pop_back();
    if ((ref & kItemBit) != 0) {
      order.push_back(ref & ~kItemBit);
      continue;
    }
    const Node& node = nodes_[ref];
    for (int c = kWidth - 1; c >= 0; --c) {
      if (node.low[0][c] <= node.high[0][c]) stack.push_back(node.child[c]);
    }
  }
  return order;
}

WideBvh::Parents WideBvh::find_parents() const {
  Parents parents;
  parents.of_node.assign(nodes_.size(), kNoParent);
  for (std::uint32_t n = 0; n < nodes_.size(); ++n) {
    for (std::uint32_t c = 0; c < kWidth; ++c) {
      const std::uint32_t child = nodes_[n].child[c];
      if (!(nodes_[n].low[0][c] <= nodes_[n].high[0][c])) continue;
      std::vector<std::uint32_t>& parent_of = (child & kItemBit) != 0 ? parents.of_item : parents.of_node;
      const std::uint32_t i = child & ~kItemBit;
      if (i >= parent_of.size()) parent_of.resize(i + 1, kNoParent);
      parent_of[i] = n * kWidth + c;
    }
  }
  return parents;
}

void WideBvh::refit(std::uint32_t item, const Box& box, const Parents& parents) noexcept {
  std::uint32_t at = parents.of_item[item];
  for (int k = 0; k < 3; ++k) {
    const bool empty = box.is_empty();
    nodes_[at / kWidth].low[k][at % kWidth] = empty ? std::numeric_limits<float>::infinity() : detail::round_down(box.low[k]);
    nodes_[at / kWidth].high[k][at % kWidth] = empty ? -std::numeric_limits<float>::infinity() : detail::round_up(box.high[k]);
  }
  for (std::uint32_t n = at / kWidth; (at = parents.of_node[n]) != kNoParent; n = at / kWidth) {
    Node& above = nodes_[at / kWidth];
    for (int k = 0; k < 3; ++k) {
      above.low[k][at % kWidth] = *std::min_element(nodes_[n].low[k].begin(), nodes_[n].low[k].end());
      above.high[k][at % kWidth] = *std::max_element(nodes_[n].high[k].begin(), nodes_[n].high[k].end());
    }
  }
}

// Goes backwards through the nodes: each comes after the one above it.
void WideBvh::refit_all(const std::function<Box(std::size_t)>& box_of) {
  for (std::size_t n = nodes_.size(); n-- > 0;) {
    Node& node = nodes_[n];
    for (int c = 0; c < kWidth; ++c) {
      if (!(node.low[0][c] <= node.high[0][c])) continue;
      if ((node.child[c] & kItemBit) != 0) {
        const Box box = box_of(node.child[c] & ~kItemBit);
        for (int k = 0; k < 3; ++k) {
          node.low[k][c] = detail::round_down(box.low[k]);
          node.high[k][c] = detail::round_up(box.high[k]);
        }
        continue;
      }
      const Node& below = nodes_[node.child[c]];
      for (int k = 0; k < 3; ++k) {
        node.low[k][c] = *std::min_element(below.low[k].begin(), below.low[k].end());
        node.high[k][c] = *std::max_element(below.high[k].begin(), below.high[k].end());
      }
    }
  }
}

void WideBvh::renumber_items(std::span<const std::uint32_t> renumbered) {
  for (Node& node : nodes_) {
    for (std::uint32_t& child : node.child) {
      if ((child & kItemBit) != 0) child = renumbered[child & ~kItemBit] | kItemBit;
    }
  }
}

}  // namespace hapton
