#pragma once

#include <algorithm>
#include <concepts>
#include <cstdint>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/math/types.h"

namespace hapton {

// A tree of boxes over a list of items. A node with more than `leaf_size` items is split at the median item, across the longest side of the
// box around their places.
//
// Construction takes n log n steps for any input, also if all places are equal. It reorders the list of items, which the caller keeps.
// Items that are integers are ordered by their value where their places are equal, so that the order in which they were given does not
// matter. Units and frame: those of the items. RT: set-up only. Threads: one (visit_open changes counts).
class MedianTree {
 public:
  struct Node {
    Eigen::AlignedBox3d box;  // around the extents of its items
    std::uint32_t first = 0;  // its items are those from `first` to before `last`
    std::uint32_t last = 0;
    std::uint32_t right = 0;       // number of the right child, 0 in a leaf; the left child is the next node
    std::uint32_t open_items = 0;  // number of items that visit_open has not finished
  };

  MedianTree() = default;

  // extent_of(item): the point or box that the item occupies. place_of(item): the point by which it is sorted. For points, both are the
  // same function, of one type. Pre: extents and places are finite; fewer than 2^32 items; leaf_size is 1 or more.
  template <class Item, class ExtentOf, class PlaceOf>
  MedianTree(std::vector<Item>& items, std::uint32_t leaf_size, const ExtentOf& extent_of, const PlaceOf& place_of) {
    static_assert(std::is_class_v<ExtentOf>, "two functions may be of one type");
    constexpr bool kArePoints = std::is_same_v<ExtentOf, PlaceOf>;  // the extent of each item is its place
    const auto build = [&](auto&& self, std::uint32_t first, std::uint32_t last) -> void {
      const std::size_t number = nodes_.size();
      Node node{.box = {}, .first = first, .last = last, .open_items = last - first};
      Eigen::AlignedBox3d places;
      for (std::uint32_t i = first; i < last; ++i) {
        places.extend(place_of(items[i]));
        if constexpr (!kArePoints) node.box.extend(extent_of(items[i]));
      }
      if constexpr (kArePoints) node.box = places;
      nodes_.push_back(node);
      if (last - first <= leaf_size) return;
      int axis = 0;
      places.sizes().maxCoeff(&axis);
      const std::uint32_t middle = first + (last - first) / 2;
      std::nth_element(items.begin() + first, items.begin() + middle, items.begin() + last, [&](const Item& a, const Item& b) {
        const double at_a = place_of(a)[axis];
        const double at_b = place_of(b)[axis];
        if constexpr (std::integral<Item>) return at_a != at_b ? at_a < at_b : a < b;
        return at_a < at_b;
      });
      self(self, first, middle);
      nodes_[number].right = static_cast<std::uint32_t>(nodes_.size());
      self(self, middle, last);
    };
    if (!items.empty()) build(build, 0, static_cast<std::uint32_t>(items.size()));
  }

  // The nodes, the root first; empty if there are no items.
  const std::vector<Node>& nodes() const noexcept { return nodes_; }

  // Calls look(leaf) for the leaves within nodes that enter(distance) accepts. Of two children it visits the one with the smaller
  // distance_of(number) first; if they are equal, the left one.
  template <class DistanceOf, class Enter, class Look>
  void visit_nearest_first(const DistanceOf& distance_of, const Enter& enter, const Look& look) const {
    const auto visit = [&](auto&& self, std::uint32_t number, double distance) -> void {
      if (!enter(distance)) return;
      const Node& node = nodes_[number];
      if (node.right == 0) return look(node);
      const std::uint32_t left = number + 1;
      const double to_left = distance_of(left);
      const double to_right = distance_of(node.right);
      const bool left_first = to_left <= to_right;
      self(self, left_first ? left : node.right, left_first ? to_left : to_right);
      self(self, left_first ? node.right : left, left_first ? to_right : to_left);
    };
    if (!nodes_.empty()) visit(visit, 0, distance_of(0));
  }

  // Calls look(i) for the items of the leaves within nodes that enter(node) accepts, from left to right. look(i) returns whether item i has
  // just been finished: the nodes that contain it then no longer count it as open.
  template <class Enter, class Look>
  void visit_open(const Enter& enter, const Look& look) {
    const auto visit = [&](auto&& self, Node& node) -> std::uint32_t {
      if (!enter(std::as_const(node))) return 0;
      std::uint32_t finished = 0;
      if (node.right != 0) {
        finished = self(self, *(&node + 1));
        finished += self(self, nodes_[node.right]);
      } else {
        for (std::uint32_t i = node.first; i < node.last; ++i) finished += look(i) ? 1 : 0;
      }
      node.open_items -= finished;
      return finished;
    };
    if (!nodes_.empty()) visit(visit, nodes_.front());
  }

 private:
  std::vector<Node> nodes_;
};

}  // namespace hapton
