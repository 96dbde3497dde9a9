#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <type_traits>
#include <vector>

#include "core/base/large_vector.h"
#include "core/collision/box.h"
#include "core/math/float8.h"

namespace hapton {

// A bounding volume tree with eight children a node, whose eight boxes are tested by one run of vector instructions. Children are nodes or
// single items (triangles). Boxes are single precision, rounded outward, relative to an origin that the caller has already subtracted, so a
// query never misses what it touches. The builder bounds the depth, and so the stack of a query, which never allocates and never drops a
// node. Threads: any number of readers while no box or number changes. RT: queries and refit yes, all else set-up only.
class WideBvh {
 public:
  static constexpr int kWidth = 8;
  // Splits follow their cost down to level 26; below, runs are halved, and 13 levels of eight children hold 2^32 items.
  static constexpr int kMaxDepth = 40;
  static constexpr int kMaxStack = kMaxDepth * (kWidth - 1) + 1;
  static constexpr double kFarthest = 0x1p100;  // pre: no coordinate of an item's box has a larger magnitude

  // Builds over item boxes (binned surface-area heuristic, MacDonald & Booth 1990, Wald 2007). Item i is boxes[i]. Pre: none is empty.
  explicit WideBvh(std::span<const Box> boxes);
  // The same with a function: the box of item i is box_of(i), which is called once for each item.
  WideBvh(std::size_t count, const std::function<Box(std::size_t)>& box_of);

  // Calls visit(item) for every item whose box overlaps the query box, and for some that nearly do. A visit that returns false ends the
  // search.
  template <class Visit>
  void for_each_overlapping(const Box& query, Visit&& visit) const;

  // Calls visit(item) for every item whose box comes within `radius` of p, and for some that nearly do, up to a distance of 2^63. A visit
  // that returns false ends the search. For this search, visit_nearest and NearestSearch, nothing is near a p that is not finite or too
  // large for a float.
  template <class Visit>
  void for_each_within(const Vec3& p, double radius, Visit&& visit) const;

  // Finds every pair of items whose boxes come within `margin` of each other along each axis, once, and some that nearly do. Takes up to
  // eight items at a time: begin(items, lanes) gives them lane by lane, with bit i of `lanes` set if lane i is used; then visit(item,
  // lanes) is called for each item near some of them, with the bits of these.
  template <class Begin, class Visit>
  void for_each_near_pair(double margin, Begin&& begin, Visit&& visit) const;

  // Calls visit(item, bound_squared) for items in roughly increasing distance from p, nearest boxes first, while a box may be nearer than
  // sqrt(bound_squared); visit returns the new bound_squared (never larger).
  template <class Visit>
  void visit_nearest(const Vec3& p, double bound_squared, Visit&& visit) const;

  // The search of visit_nearest, one item at a time, so that it can be interrupted. RT: yes. Pre: no box changes until it ends.
  class NearestSearch {
   public:
    void start(const Vec3& p) noexcept {
      p_ = p;
      top_ = 0;
      stack_[top_++] = {0, 0.0F};
    }
    // The next item whose box may be nearer than sqrt(bound_squared). None: the search has ended.
    std::optional<std::uint32_t> next(const WideBvh& tree, double bound_squared) noexcept;

   private:
    friend class WideBvh;
    struct Entry {
      std::uint32_t child;
      float distance_squared;
    };

    Vec3 p_ = Vec3::Zero();
    std::array<Entry, kMaxStack> stack_;  // set below top_
    int top_ = 0;
  };

  // Calls visit(item, until) for items whose boxes come within `radius` (along each axis) of a point that moves from p at time 0 to p +
  // motion at time 1, before the time `until`, roughly in order; visit returns the new `until` (never larger; below zero: ends the search).
  // Also for some boxes that nearly do. Pre: p and motion are of the size of the boxes' coordinates.
  template <class Visit>
  void visit_along(const Vec3& p, const Vec3& motion, double radius, double until, Visit&& visit) const;

  // Items in tree order: neighbours in space are neighbours in this list. Empty for an empty tree.
  LargeVector<std::uint32_t> items_in_tree_order() const;

  // Where the box of each item and of each node is stored, as node * kWidth + child: the path upwards, for refit. The root has kNoParent.
  // Pre: no box is empty. RT: set-up only.
  static constexpr std::uint32_t kNoParent = 0xFFFFFFFFU;
  struct Parents {
    std::vector<std::uint32_t> of_item;
    std::vector<std::uint32_t> of_node;
  };
  Parents find_parents() const;

  // Gives the item a new box and updates those above it; no query finds an item with an empty box. Work: one node per level. Pre: `parents`
  // are those of this tree. RT: yes.
  void refit(std::uint32_t item, const Box& box, const Parents& parents) noexcept;

  // Gives every item a new box: box_of(i), called once. Linear in the items. Pre: no box is or was empty. RT: set-up only.
  void refit_all(const std::function<Box(std::size_t)>& box_of);

  std::size_t node_count() const { return nodes_.size(); }
  std::size_t bytes() const { return nodes_.capacity() * sizeof(Node); }
  int depth() const { return depth_; }

  // Renumbers the items: new number of item i is renumbered[i].
  void renumber_items(std::span<const std::uint32_t> renumbered);

 private:
  static constexpr std::uint32_t kItemBit = 0x80000000U;

  // An unused child has low > high, so nothing overlaps it.
  struct alignas(32) Node {
    std::array<std::array<float, kWidth>, 3> low;
    std::array<std::array<float, kWidth>, 3> high;
    std::array<std::uint32_t, kWidth> child;  // kItemBit set: an item; else a node
  };

  // Prefetches the whole of a node that is processed later.
  static void prefetch(const Node& node) {
    const auto* bytes = reinterpret_cast<const char*>(&node);
    for (std::size_t at = 0; at < sizeof(Node); at += 64) __builtin_prefetch(bytes + at);
  }

  // Eight boxes, or one box eight times.
  struct Boxes8 {
    Float8 low[3];
    Float8 high[3];

    unsigned overlapping(const Boxes8& other) const {
      Float8 hit = (low[0] <= other.high[0]) & (high[0] >= other.low[0]);
      for (int k = 1; k < 3; ++k) {
        hit = hit & (low[k] <= other.high[k]);
        hit = hit & (high[k] >= other.low[k]);
      }
      return sign_bits(hit);
    }
  };
  static Boxes8 boxes_of(const Node& node) {
    Boxes8 boxes;
    for (int k = 0; k < 3; ++k) {
      boxes.low[k] = Float8::load(node.low[k].data());
      boxes.high[k] = Float8::load(node.high[k].data());
    }
    return boxes;
  }
  static Boxes8 box_of(const Node& node, int c) {
    Boxes8 box;
    for (int k = 0; k < 3; ++k) {
      box.low[k] = Float8(node.low[k][c]);
      box.high[k] = Float8(node.high[k][c]);
    }
    return box;
  }
  static unsigned item_lanes(const Node& node);

  // Lower bounds of the squared distances of a point from the boxes of a node, in single precision.
  struct PointDistance {
    explicit PointDistance(const Vec3& p);
    Float8 squared(const Node& node) const;

    Float8 point[3];
    Float8 error;  // largest rounding error of a coordinate of the point
  };
  int push_nearer(const Node& node, const PointDistance& distance_of, double bound_squared, NearestSearch::Entry* stack, int top) const;

  struct Builder;

  LargeVector<Node> nodes_;
  int depth_ = 0;
};

namespace detail {

// A float not above x (round_down) or not below x (round_up), within 2^-21 of its magnitude plus 2^-125. x: fits in a float.
inline float round_down(double x) {
  const auto f = static_cast<float>(x);
  return f - std::fabs(f) * 0x1p-22F - std::numeric_limits<float>::min();
}
inline float round_up(double x) {
  const auto f = static_cast<float>(x);
  return f + std::fabs(f) * 0x1p-22F + std::numeric_limits<float>::min();
}

}  // namespace detail

// The point's own rounding is below 2^-24 of its magnitude, and subtracted from every distance. The relative rounding of the subtraction,
// square and sum is below 8 * 2^-24; kRounding takes off twice as much.
inline WideBvh::PointDistance::PointDistance(const Vec3& p) {
  float most = 0.0F;
  for (int k = 0; k < 3; ++k) {
    point[k] = Float8(static_cast<float>(p[k]));
    most = std::max(most, detail::round_up(std::abs(p[k]) / 8388608.0));
  }
  error = Float8(most);
}

inline Float8 WideBvh::PointDistance::squared(const Node& node) const {
  constexpr float kRounding = 1.0F - 16.0F / 16777216.0F;  // the sum of three squares has a rounding error below 16 x 2^-24
  const Float8 zero = Float8(0.0F);
  Float8 sum = zero;
  for (int k = 0; k < 3; ++k) {
    const Float8 below = Float8::load(node.low[k].data()) - point[k];
    const Float8 above = point[k] - Float8::load(node.high[k].data());
    // Zero is the first operand: where one operand is NaN, as it can be for a point that is not finite, max gives the second one, NaN, and
    // the point is then near no box, not even that of an unused child.
    const Float8 outside = max(zero, max(below, above) - error);
    sum = sum + outside * outside;
  }
  return sum * Float8(kRounding);
}

template <class Visit>
void WideBvh::for_each_overlapping(const Box& query, Visit&& visit) const {
  if (nodes_.empty()) return;
  Float8 low[3];
  Float8 high[3];
  for (int k = 0; k < 3; ++k) {
    // Finite, whatever the query: an unused child's inverted infinite box must overlap nothing.
    low[k] = Float8(detail::round_down(std::clamp(query.low[k], -kFarthest, kFarthest)));
    high[k] = Float8(detail::round_up(std::clamp(query.high[k], -kFarthest, kFarthest)));
  }
  std::array<std::uint32_t, kMaxStack> stack;
  int top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Node& node = nodes_[stack[--top]];
    Float8 hit = Float8::load(node.low[0].data()) <= high[0];
    hit = hit & (Float8::load(node.high[0].data()) >= low[0]);
    for (int k = 1; k < 3; ++k) {
      hit = hit & (Float8::load(node.low[k].data()) <= high[k]);
      hit = hit & (Float8::load(node.high[k].data()) >= low[k]);
    }
    for (auto mask = sign_bits(hit); mask != 0; mask &= mask - 1) {
      const std::uint32_t child = node.child[std::countr_zero(mask)];
      if ((child & kItemBit) != 0) {
        if constexpr (std::is_same_v<decltype(visit(child)), bool>) {
          if (!visit(child & ~kItemBit)) return;
        } else {
          visit(child & ~kItemBit);
        }
      } else {
        prefetch(nodes_[child]);
        stack[top++] = child;
      }
    }
  }
}

inline unsigned WideBvh::item_lanes(const Node& node) {
  const Uint32x8 child = Uint32x8::load_unaligned(node.child.data());
  const Float8 used = Float8::load(node.low[0].data()) <= Float8::load(node.high[0].data());
  return sign_bits(as_floats(child) & used);
}

// A node comes before all below it, so a pair is found from the later of the two nodes with its items: later nodes are skipped.
template <class Begin, class Visit>
void WideBvh::for_each_near_pair(double margin, Begin&& begin, Visit&& visit) const {
  std::array<std::uint32_t, kMaxStack> stack;
  for (std::uint32_t own = 0; own < nodes_.size(); ++own) {
    const Node& node = nodes_[own];
    const unsigned lanes = item_lanes(node);
    if (lanes == 0) continue;
    std::array<std::uint32_t, kWidth> items;
    for (int c = 0; c < kWidth; ++c) items[c] = node.child[c] & ~kItemBit;
    begin(items, lanes);
    Boxes8 boxes = boxes_of(node);
    Box all;
    for (unsigned mask = lanes; mask != 0; mask &= mask - 1) {
      const int c = std::countr_zero(mask);
      all.grow(Box{{node.low[0][c], node.low[1][c], node.low[2][c]}, {node.high[0][c], node.high[1][c], node.high[2][c]}});
    }
    Boxes8 around;
    for (int k = 0; k < 3; ++k) {
      around.low[k] = Float8(detail::round_down(all.low[k] - margin));
      around.high[k] = Float8(detail::round_up(all.high[k] + margin));
      const double size = std::max(std::abs(all.low[k]), std::abs(all.high[k])) + margin;
      const Float8 wider = Float8(detail::round_up(margin + size * 0x1p-22));
      boxes.low[k] = boxes.low[k] - wider;
      boxes.high[k] = boxes.high[k] + wider;
    }
    int top = 0;
    stack[top++] = 0;
    while (top > 0) {
      const std::uint32_t at = stack[--top];
      const Node& other = nodes_[at];
      const unsigned is_item = item_lanes(other);
      for (unsigned mask = boxes_of(other).overlapping(around); mask != 0; mask &= mask - 1) {
        const int c = std::countr_zero(mask);
        const std::uint32_t child = other.child[c];
        if ((is_item >> c & 1U) == 0) {
          if (child <= own) stack[top++] = child;
          continue;
        }
        const unsigned earlier = at == own ? (1U << c) - 1U : ~0U;
        const unsigned near = boxes.overlapping(box_of(other, c)) & lanes & earlier;
        if (near != 0) visit(child & ~kItemBit, near);
      }
    }
  }
}

template <class Visit>
void WideBvh::for_each_within(const Vec3& p, double radius, Visit&& visit) const {
  if (nodes_.empty()) return;
  const PointDistance distance_of(p);
  // Finite, whatever the radius: an unused child is infinitely far.
  const Float8 bound = Float8(std::min(detail::round_up(radius * radius), std::numeric_limits<float>::max()));
  std::array<std::uint32_t, kMaxStack> stack;
  int top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Node& node = nodes_[stack[--top]];
    for (auto mask = sign_bits(distance_of.squared(node) <= bound); mask != 0; mask &= mask - 1) {
      const std::uint32_t child = node.child[std::countr_zero(mask)];
      if ((child & kItemBit) == 0) {
        prefetch(nodes_[child]);
        stack[top++] = child;
      } else if (!visit(child & ~kItemBit)) {
        return;
      }
    }
  }
}

// Puts the children of a node that may be nearer than the bound on the stack, the nearest on top.
inline int WideBvh::push_nearer(const Node& node, const PointDistance& distance_of, double bound_squared, NearestSearch::Entry* stack,
                                int top) const {
  const Float8 sum = distance_of.squared(node);
  const Float8 bound = Float8(detail::round_up(bound_squared));
  auto mask = sign_bits(sum < bound);
  alignas(32) std::array<float, kWidth> distance;
  store(distance.data(), sum);
  const int first = top;
  for (; mask != 0; mask &= mask - 1) {
    const int c = std::countr_zero(mask);
    const NearestSearch::Entry next = {node.child[c], distance[c]};
    if ((next.child & kItemBit) == 0) prefetch(nodes_[next.child]);
    int at = top++;
    for (; at > first && stack[at - 1].distance_squared < next.distance_squared; --at) stack[at] = stack[at - 1];
    stack[at] = next;
  }
  return top;
}

template <class Visit>
void WideBvh::visit_nearest(const Vec3& p, double bound_squared, Visit&& visit) const {
  if (nodes_.empty()) return;
  const PointDistance distance_of(p);
  std::array<NearestSearch::Entry, kMaxStack> stack;
  int top = 0;
  stack[top++] = {0, 0.0F};
  while (top > 0) {
    const NearestSearch::Entry entry = stack[--top];
    if (static_cast<double>(entry.distance_squared) >= bound_squared) continue;
    if ((entry.child & kItemBit) != 0) {
      bound_squared = visit(entry.child & ~kItemBit, bound_squared);
      continue;
    }
    top = push_nearer(nodes_[entry.child], distance_of, bound_squared, stack.data(), top);
  }
}

inline std::optional<std::uint32_t> WideBvh::NearestSearch::next(const WideBvh& tree, double bound_squared) noexcept {
  if (tree.nodes_.empty()) return std::nullopt;
  const PointDistance distance_of(p_);
  while (top_ > 0) {
    const Entry entry = stack_[--top_];
    if (static_cast<double>(entry.distance_squared) >= bound_squared) continue;
    if ((entry.child & kItemBit) != 0) return entry.child & ~kItemBit;
    top_ = tree.push_nearer(tree.nodes_[entry.child], distance_of, bound_squared, stack_.data(), top_);
  }
  return std::nullopt;
}

template <class Visit>
void WideBvh::visit_along(const Vec3& p, const Vec3& motion, double radius, double until, Visit&& visit) const {
  if (nodes_.empty()) return;
  // Slabs in single precision from a start rounded to float. Boxes grow by the rounding of the start and the subtraction, a few units of
  // 2^-24 of the coordinates; times are widened by the rounding of the reciprocal and the product.
  constexpr float kRounding = 16.0F / 16777216.0F;
  // With coordinates of about 1, a shorter motion counts as none; its inverse, 2^100, is still a float.
  constexpr double kMinMotion = 0x1p-100;
  Float8 start[3];
  Float8 inverse[3];
  float size = 1.0F;
  for (int k = 0; k < 3; ++k) size = std::max(size, detail::round_up(std::abs(p[k]) + std::abs(motion[k])));
  const Float8 error = Float8(size / 2097152.0F + detail::round_up(radius));
  for (int k = 0; k < 3; ++k) {
    start[k] = Float8(static_cast<float>(p[k]));
    const double least = motion[k] < 0.0 ? std::min(motion[k], -kMinMotion) : std::max(motion[k], kMinMotion);
    inverse[k] = Float8(static_cast<float>(1.0 / least));
  }
  const Float8 zero = Float8(0.0F);
  const Float8 sooner = Float8(1.0F - kRounding);
  const Float8 later = Float8(1.0F + kRounding);
  struct Entry {
    std::uint32_t child;
    float time;
  };
  std::array<Entry, kMaxStack> stack;
  int top = 0;
  stack[top++] = {0, 0.0F};
  while (top > 0) {
    const Entry entry = stack[--top];
    if (static_cast<double>(entry.time) > until) continue;
    if ((entry.child & kItemBit) != 0) {
      until = visit(entry.child & ~kItemBit, until);
      continue;
    }
    const Node& node = nodes_[entry.child];
    Float8 enter = zero;
    Float8 leave = Float8(detail::round_up(until));
    for (int k = 0; k < 3; ++k) {
      const Float8 low = Float8::load(node.low[k].data()) - start[k] - error;
      const Float8 high = Float8::load(node.high[k].data()) - start[k] + error;
      const Float8 a = low * inverse[k];
      const Float8 b = high * inverse[k];
      const bool forward = motion[k] >= 0.0;
      enter = max(enter, (forward ? a : b) * sooner);
      leave = min(leave, (forward ? b : a) * later);
    }
    auto mask = sign_bits(enter <= leave);
    alignas(32) std::array<float, kWidth> time;
    store(time.data(), enter);
    const int first = top;
    for (; mask != 0; mask &= mask - 1) {  // insertion by time: the earliest ends on top
      const int c = std::countr_zero(mask);
      const Entry next = {node.child[c], time[c]};
      if ((next.child & kItemBit) == 0) prefetch(nodes_[next.child]);
      int at = top++;
      for (; at > first && stack[at - 1].time < next.time; --at) stack[at] = stack[at - 1];
      stack[at] = next;
    }
  }
}

}  // namespace hapton
