#include "tools/session/first_shapes.h"

#include <iterator>

namespace hapton {

void FirstShapes::add(std::uint64_t sender, const ForceCommand& force) {
  SenderShapes& sender_shapes = senders_[sender];
  if (sender_shapes.first) return;
  sender_shapes.first = force.shape_serial;
  sender_shapes.shapes.erase(sender_shapes.shapes.upper_bound(force.shape_serial), sender_shapes.shapes.end());
  std::erase_if(sender_shapes.starts, [&](const auto& one) { return one.first.first > force.shape_serial; });
}

void FirstShapes::add(std::uint64_t sender, const ObjectShape& shape) {
  SenderShapes& sender_shapes = senders_[sender];
  if (sender_shapes.first && shape.serial > *sender_shapes.first) return;
  sender_shapes.shapes.try_emplace(shape.serial, shape.part.total).first->second.add(shape.part);
  if (sender_shapes.shapes.size() > kMaxEarly) sender_shapes.shapes.erase(sender_shapes.shapes.begin());
}

void FirstShapes::add(std::uint64_t sender, const ShapeStart& start) {
  SenderShapes& sender_shapes = senders_[sender];
  if (sender_shapes.first && start.serial > *sender_shapes.first) return;
  sender_shapes.starts[{start.serial, start.object}] = start;
  if (sender_shapes.starts.size() > kMaxEarly) sender_shapes.starts.erase(sender_shapes.starts.begin());
}

const FirstShapes::SenderShapes* FirstShapes::find(std::uint64_t sender) const {
  const auto found = senders_.find(sender);
  return found != senders_.end() ? &found->second : nullptr;
}

}  // namespace hapton
