#include "core/collision/object_hierarchy.h"

namespace hapton {

// An object whose box is empty also gets a leaf, in the middle of the others; afterwards its box in the tree is made empty.
ObjectHierarchy::ObjectHierarchy(std::span<const Box> bounds) : bounds_(bounds.begin(), bounds.end()) {
  Box all;
  for (const Box& box : bounds_) all.grow(box);
  const Vec3 middle = all.is_empty() ? Vec3(Vec3::Zero()) : all.centre();
  tree_ = WideBvh(bounds_.size(), [&](std::size_t i) { return bounds_[i].is_empty() ? Box{middle, middle} : bounds_[i]; });
  parents_ = tree_.find_parents();
  for (std::uint32_t i = 0; i < bounds_.size(); ++i) {
    if (bounds_[i].is_empty()) tree_.refit(i, Box(), parents_);
  }
}

std::size_t ObjectHierarchy::bytes() const {
  return tree_.bytes() + bounds_.capacity() * sizeof(Box) +
         (parents_.of_item.capacity() + parents_.of_node.capacity()) * sizeof(std::uint32_t);
}

void ObjectHierarchy::refit(std::uint32_t object, const Box& bounds) noexcept {
  bounds_[object] = bounds;
  tree_.refit(object, bounds, parents_);
}

}  // namespace hapton
