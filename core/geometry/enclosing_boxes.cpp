#include "core/geometry/enclosing_boxes.h"

#include <algorithm>
#include <utility>

namespace hapton {

EnclosingBoxes::EnclosingBoxes(std::vector<Box> boxes) : boxes_(std::move(boxes)) {
  if (!boxes_.empty()) build(0, static_cast<std::uint32_t>(boxes_.size()));
}

// By the middles of the boxes, across the longest side of what these take.
std::uint32_t EnclosingBoxes::build(std::uint32_t first, std::uint32_t last) {
  const auto number = static_cast<std::uint32_t>(nodes_.size());
  Node node{.around = {}, .first = first, .last = last};
  Box middles;
  for (std::uint32_t i = first; i < last; ++i) {
    node.around.extend(boxes_[i]);
    middles.extend(boxes_[i].center());
  }
  nodes_.push_back(node);
  if (last - first <= kLeafSize) return number;
  int axis = 0;
  middles.sizes().maxCoeff(&axis);
  const std::uint32_t middle = first + (last - first) / 2;
  std::nth_element(boxes_.begin() + first, boxes_.begin() + middle, boxes_.begin() + last,
                   [axis](const Box& a, const Box& b) { return a.center()[axis] < b.center()[axis]; });
  build(first, middle);
  const std::uint32_t right = build(middle, last);
  nodes_[number].right = right;
  return number;
}

bool EnclosingBoxes::contain(const Box& box) { return !nodes_.empty() && is_contained(0, box); }

bool EnclosingBoxes::is_contained(std::uint32_t number, const Box& box) {
  const Node& node = nodes_[number];
  ++compared_;
  if (!node.around.contains(box)) return false;
  if (node.right != 0) return is_contained(number + 1, box) || is_contained(node.right, box);
  for (std::uint32_t i = node.first; i < node.last; ++i) {
    ++compared_;
    if (boxes_[i].contains(box)) return true;
  }
  return false;
}

}  // namespace hapton
