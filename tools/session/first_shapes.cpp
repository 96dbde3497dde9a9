#include "tools/session/first_shapes.h"

#include <iterator>

namespace hapton {

void FirstShapes::add(std::uint64_t sender, const ForceCommand& force) {
  Sender& own = senders_[sender];
  if (own.first) return;
  own.first = force.shape_serial;
  own.shapes.erase(own.shapes.upper_bound(force.shape_serial), own.shapes.end());
  std::erase_if(own.starts, [&](const auto& one) { return one.first.first > force.shape_serial; });
}

void FirstShapes::add(std::uint64_t sender, const ObjectShape& shape) {
  Sender& own = senders_[sender];
  if (own.first && shape.serial > *own.first) return;
  own.shapes.try_emplace(shape.serial, shape.part.total).first->second.add(shape.part);
  if (own.shapes.size() > kMaxEarly) own.shapes.erase(own.shapes.begin());
}

void FirstShapes::add(std::uint64_t sender, const ShapeStart& start) {
  Sender& own = senders_[sender];
  if (own.first && start.serial > *own.first) return;
  own.starts[{start.serial, start.object}] = start;
  if (own.starts.size() > kMaxEarly) own.starts.erase(own.starts.begin());
}

const FirstShapes::Sender* FirstShapes::find(std::uint64_t sender) const {
  const auto found = senders_.find(sender);
  return found != senders_.end() ? &found->second : nullptr;
}

}  // namespace hapton
