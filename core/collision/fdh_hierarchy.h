#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/collision/fdh_directions.h"
#include "core/collision/fdh_topology.h"
#include "core/math/float8.h"

namespace hapton {

// Work counters of a query.
struct FdhVisits {
  std::uint32_t nodes = 0;  // eight-wide nodes opened
  std::uint32_t leaves = 0;
  std::uint32_t items = 0;  // triangles (or objects) in those leaves

  FdhVisits& operator+=(const FdhVisits& other) {
    nodes += other.nodes;
    leaves += other.leaves;
    items += other.items;
    return *this;
  }
};

namespace detail {

// A float below / above x, by at least half a unit in the last place, u: (float)x is within u / 2 of x, what is subtracted is between 2 u
// and 4 u, and rounding the difference changes it by at most u / 2. The constant is for subnormal numbers. For |x| beyond 3e38 the result
// is about 3e38 or infinite, whichever is on the right side.
inline float float_below(double x) {
  const auto f = static_cast<float>(x < 3e38 ? x : 3e38);
  return f - (std::fabs(f) * 0x1p-22F + 0x1p-140F);
}
inline float float_above(double x) {
  const auto f = static_cast<float>(x > -3e38 ? x : -3e38);
  return f + (std::fabs(f) * 0x1p-22F + 0x1p-140F);
}

}  // namespace detail

// The extent of a query on every axis, from low to high, in single precision, rounded outward: nodes are compared with it.
template <int K>
struct FdhInterval {
  std::array<float, K / 2> low;
  std::array<float, K / 2> high;
};

// A bounding volume hierarchy of Fixed Direction Hulls with K planes over numbered items: nodes of eight children in one array, one run of
// vector instructions per plane pair, the box's three pairs first (FDH paper, section 5). Planes are relative to the owner's centre, in
// single precision, rounded outward, so no query misses an item that it touches. Threads: const calls from any number of threads. RT:
// traversals yes (fixed stack, see FdhTopology), the rest set-up only.
template <int K>
class FdhHierarchy {
 public:
  static constexpr int kAxes = K / 2;
  static constexpr int kWidth = FdhTopology::kWidth;

  void adopt(const FdhTopology& topology) {
    depth_ = topology.depth;
    nodes_.resize(topology.nodes.size());
    for (std::size_t i = 0; i < nodes_.size(); ++i) nodes_[i].child = topology.nodes[i];
  }

  // Recomputes every plane, bottom-up; hull_of(first, count) is the hull of that run of items in tree order, relative to the centre;
  // `rounding` (absolute, >= 0, per axis) covers the rounding of hulls and queries. RT: set-up only; no heap, but it visits every node.
  template <class HullOf>
  void refit(double rounding, HullOf&& hull_of) {
    for (std::size_t n = nodes_.size(); n-- > 0;) {  // children come after their parents
      Node& node = nodes_[n];
      for (int c = 0; c < kWidth; ++c) {
        const std::uint32_t child = node.child[c];
        if (child == FdhTopology::kNothing) {
          for (int i = 0; i < kAxes; ++i) {
            node.low[i].set_lane(c, std::numeric_limits<float>::infinity());
            node.high[i].set_lane(c, -std::numeric_limits<float>::infinity());
          }
        } else if (FdhTopology::is_leaf(child)) {
          const FdhHull<K> hull = hull_of(FdhTopology::leaf_first(child), FdhTopology::leaf_count(child));
          for (int i = 0; i < kAxes; ++i) {
            node.low[i].set_lane(c, detail::float_below(hull.low[i] - rounding));
            node.high[i].set_lane(c, detail::float_above(hull.high[i] + rounding));
          }
        } else {
          const Node& below = nodes_[child];
          for (int i = 0; i < kAxes; ++i) {
            float low = below.low[i][0];
            float high = below.high[i][0];
            for (int k = 1; k < kWidth; ++k) {
              low = below.low[i][k] < low ? below.low[i][k] : low;
              high = below.high[i][k] > high ? below.high[i][k] : high;
            }
            node.low[i].set_lane(c, low);
            node.high[i].set_lane(c, high);
          }
        }
      }
    }
  }

  // Calls leaf(first, count) for every leaf whose hull overlaps the interval.
  template <class Leaf>
  FdhVisits walk_overlapping(const FdhInterval<K>& q, Leaf&& leaf) const {
    return walk(
        [&q](const Node& node) {
          // An unused child is empty, low above high; an unbounded query would still accept it.
          Float8 hit = (node.low[0] <= q.high[0]) & (node.high[0] >= q.low[0]) & (node.low[0] <= node.high[0]);
          for (int i = 1; i < 3; ++i) hit = hit & (node.low[i] <= q.high[i]) & (node.high[i] >= q.low[i]);
          if constexpr (kAxes > 3) {
            if (sign_bits(hit) == 0) return 0U;
            for (int i = 3; i < kAxes; ++i) hit = hit & (node.low[i] <= q.high[i]) & (node.high[i] >= q.low[i]);
          }
          return sign_bits(hit);
        },
        leaf);
  }

  // The segment p + t d, t in [0, 1], which is tested against hulls that are grown on every axis. See make_sweep.
  struct Sweep {
    std::array<float, kAxes> from;
    std::array<float, kAxes> inverse;  // 1 / d along the axis
    std::array<float, kAxes> grow;     // what hulls are grown by along the axis, including rounding
  };

  // The sweep of a ball of this radius between two points, given by their projections relative to the centre. `grow` covers rounding of
  // |from| 2^-24 each for the start and for its difference from a plane; times have a relative error below 2^-21, which their comparison
  // allows for. A d shorter than the padding is replaced by one of that length, and `grow` covers the change, so no inverse overflows.
  // Pre: the ends are so near to the centre that their projections and 1 / d are within the range of a normal float.
  static Sweep make_sweep(const std::array<double, kAxes>& from, const std::array<double, kAxes>& to, double radius) {
    Sweep sweep;
    for (int i = 0; i < kAxes; ++i) {
      const double pad = 0x1p-21 * (std::fabs(from[i]) + std::fabs(to[i])) + kMinPad;
      double d = to[i] - from[i];
      double grow = radius * std::sqrt(static_cast<double>(FdhDirections<K>::length_squared(i))) * (1.0 + kNodeRounding) + pad;
      if (std::fabs(d) < pad) {
        d = d < 0.0 ? -pad : pad;
        grow += 2.0 * pad;
      }
      sweep.from[i] = static_cast<float>(from[i]);
      sweep.inverse[i] = static_cast<float>(1.0 / d);
      sweep.grow[i] = detail::float_above(grow);
    }
    return sweep;
  }

  // Calls leaf(first, count) for every leaf whose hull the sweep meets.
  template <class Leaf>
  FdhVisits walk_swept(const Sweep& q, Leaf&& leaf) const {
    return walk(
        [&q](const Node& node) {
          Float8 enter = Float8(0.0F);
          Float8 exit = Float8(1.0F);
          const auto clip = [&](int i) {
            // Growing the planes rounds them too: by at most 2^-23 of their size, which the padding of the leaf planes covers.
            const Float8 a = ((node.low[i] - q.grow[i]) - q.from[i]) * q.inverse[i];
            const Float8 b = ((node.high[i] + q.grow[i]) - q.from[i]) * q.inverse[i];
            enter = max(enter, min(a, b));
            exit = min(exit, max(a, b));
          };
          constexpr float kTimeRounding = 4e-6F;  // 64 times the 2^-24 of a time
          for (int i = 0; i < 3; ++i) clip(i);
          const Float8 used = node.low[0] <= node.high[0];
          if constexpr (kAxes > 3) {
            if (sign_bits((enter <= exit + kTimeRounding) & used) == 0) return 0U;
            for (int i = 3; i < kAxes; ++i) clip(i);
          }
          return sign_bits((enter <= exit + kTimeRounding) & used);
        },
        leaf);
  }

  // Calls leaf(first, count), the nearest hulls of each node first, while a hull may be nearer to the interval than the square root of
  // bound_squared(), which `leaf` reduces as it finds nearer items. The distances of hulls are lower bounds of the Euclidean ones.
  template <class Bound, class Leaf>
  FdhVisits walk_nearest(const FdhInterval<K>& q, Bound&& bound_squared, Leaf&& leaf) const {
    FdhVisits visits;
    if (nodes_.empty()) return visits;
    struct Entry {
      std::uint32_t child;
      float distance_squared;
    };
    std::array<Entry, FdhTopology::kMaxStack> stack;
    int top = 0;
    stack[top++] = {0, 0.0F};
    float max_squared = slackened(bound_squared());
    while (top > 0) {
      const Entry entry = stack[--top];
      if (!(entry.distance_squared <= max_squared)) continue;
      if (FdhTopology::is_leaf(entry.child)) {
        const std::uint32_t count = FdhTopology::leaf_count(entry.child);
        ++visits.leaves;
        visits.items += count;
        leaf(FdhTopology::leaf_first(entry.child), count);
        max_squared = slackened(bound_squared());
        continue;
      }
      ++visits.nodes;
      const Node& node = nodes_[entry.child];
      const Float8 zero = Float8(0.0F);
      const auto gap = [&](int i) { return max(max(node.low[i] - q.high[i], q.low[i] - node.high[i]), zero); };
      const Float8 gx = gap(0);
      const Float8 gy = gap(1);
      const Float8 gz = gap(2);
      Float8 distance = gx * gx + gy * gy + gz * gz;
      unsigned mask = sign_bits(distance <= max_squared) & node.used();
      if constexpr (kAxes > 3) {
        if (mask == 0) continue;
        for (int i = 3; i < kAxes; ++i) {
          const Float8 g = gap(i);
          // Rounded down, so that the bound stays below the distance.
          constexpr std::array<float, 4> kInverseLengthSquared = {0.0F, 1.0F, 0.4999999F, 0.3333333F};
          distance = max(distance, g * g * kInverseLengthSquared[FdhDirections<K>::length_squared(i)]);
        }
        mask &= sign_bits(distance <= max_squared);
      }
      const int first = top;
      for (; mask != 0; mask &= mask - 1) {
        const int c = std::countr_zero(mask);
        const Entry next = {node.child[c], distance[c]};
        int at = top++;
        for (; at > first && stack[at - 1].distance_squared < next.distance_squared; --at) stack[at] = stack[at - 1];
        stack[at] = next;
      }
    }
    return visits;
  }

  // Calls visit(hull, first, count) for every hull at depth `level` (0: the children of the root), and for leaves at smaller depths. Planes
  // are relative to the centre; the hull holds `count` items from `first` on, in tree order. For pictures of the hulls. RT: no.
  template <class Visit>
  void for_each_hull(int level, Visit&& visit) const {
    if (!nodes_.empty()) visit_hulls(0, level, visit);
  }

  std::size_t node_count() const { return nodes_.size(); }
  std::size_t bytes() const { return nodes_.capacity() * sizeof(Node); }
  int depth() const { return depth_; }

 private:
  struct alignas(32) Node {
    std::array<Float8, kAxes> low;
    std::array<Float8, kAxes> high;
    FdhTopology::Children child;

    unsigned used() const { return sign_bits(low[0] <= high[0]); }
  };

  // Relative error of a node's distance: five roundings of 2^-24 at most (difference, square, two sums, scale), times three.
  static constexpr double kNodeRounding = 0x1p-20;
  // The padding of a sweep that begins and ends at the centre itself: 2^-50 of the smallest extent that a tree accepts (1e-15). Its
  // inverse, 2^100, is still a float.
  static constexpr double kMinPad = 0x1p-100;

  static float slackened(double squared) { return detail::float_above(squared * (1.0 + kNodeRounding)); }

  template <class Visit>
  void visit_hulls(std::uint32_t at, int level, Visit& visit) const {
    const Node& node = nodes_[at];
    for (int c = 0; c < kWidth; ++c) {
      const std::uint32_t child = node.child[c];
      if (child == FdhTopology::kNothing) continue;
      if (level > 0 && !FdhTopology::is_leaf(child)) {
        visit_hulls(child, level - 1, visit);
        continue;
      }
      FdhHull<K> hull;
      for (int i = 0; i < kAxes; ++i) {
        hull.low[i] = static_cast<double>(node.low[i][c]);
        hull.high[i] = static_cast<double>(node.high[i][c]);
      }
      const auto [first, end] = run_below(child);
      visit(hull, first, end - first);
    }
  }
  // The first of the items below a child, and the end of their run, one after the last.
  std::array<std::uint32_t, 2> run_below(std::uint32_t child) const {
    if (FdhTopology::is_leaf(child))
      return {FdhTopology::leaf_first(child), FdhTopology::leaf_first(child) + FdhTopology::leaf_count(child)};
    std::array<std::uint32_t, 2> run = {std::numeric_limits<std::uint32_t>::max(), 0};
    for (const std::uint32_t below : nodes_[child].child) {
      if (below == FdhTopology::kNothing) continue;
      const auto [first, end] = run_below(below);
      run = {std::min(run[0], first), std::max(run[1], end)};
    }
    return run;
  }

  template <class Test, class Leaf>
  FdhVisits walk(Test&& test, Leaf&& leaf) const {
    FdhVisits visits;
    if (nodes_.empty()) return visits;
    std::array<std::uint32_t, FdhTopology::kMaxStack> stack;
    int top = 0;
    stack[top++] = 0;
    while (top > 0) {
      const Node& node = nodes_[stack[--top]];
      ++visits.nodes;
      for (unsigned mask = test(node); mask != 0; mask &= mask - 1) {
        const std::uint32_t child = node.child[std::countr_zero(mask)];
        if (FdhTopology::is_leaf(child)) {
          const std::uint32_t count = FdhTopology::leaf_count(child);
          ++visits.leaves;
          visits.items += count;
          leaf(FdhTopology::leaf_first(child), count);
        } else {
          stack[top++] = child;
        }
      }
    }
    return visits;
  }

  std::vector<Node> nodes_;
  int depth_ = 0;
};

}  // namespace hapton
