#include "core/geometry/enclosing_boxes.h"

#include <functional>
#include <utility>

namespace hapton {

EnclosingBoxes::EnclosingBoxes(std::vector<Box> boxes)
    : boxes_(std::move(boxes)), tree_(boxes_, kLeafSize, std::identity{}, [](const Box& box) -> Vec3 { return box.center(); }) {}

bool EnclosingBoxes::contain(const Box& box) { return !tree_.nodes().empty() && is_contained(0, box); }

bool EnclosingBoxes::is_contained(std::uint32_t number, const Box& box) {
  const MedianTree::Node& node = tree_.nodes()[number];
  ++comparisons_;
  if (!node.box.contains(box)) return false;
  if (node.right != 0) return is_contained(number + 1, box) || is_contained(node.right, box);
  for (std::uint32_t i = node.first; i < node.last; ++i) {
    ++comparisons_;
    if (boxes_[i].contains(box)) return true;
  }
  return false;
}

}  // namespace hapton
