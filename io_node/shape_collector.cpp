#include "io_node/shape_collector.h"

#include <algorithm>

namespace hapton {

// The record of the object's newest shape, which is begun anew if `serial` is newer. Null: the serial is older, the haptics process was
// replaced, there are too many objects, or `total` is not that of the shape.
ShapeCollector::NewestShape* ShapeCollector::find_or_begin(std::uint32_t source, std::int32_t object, std::uint32_t serial,
                                                           std::uint32_t total, Arrival arrival) noexcept {
  const HapticsSource::Verdict verdict = processes_.note(source, arrival);
  if (verdict == HapticsSource::Verdict::old) return nullptr;
  if (verdict == HapticsSource::Verdict::other) objects_.fill({});
  source_ = source;
  auto found = std::find_if(objects_.begin(), objects_.end(), [&](const NewestShape& one) { return one.object == object; });
  if (found == objects_.end())
    found = std::find_if(objects_.begin(), objects_.end(), [](const NewestShape& one) { return one.object < 0; });
  if (found == objects_.end() || serial < found->serial) return nullptr;
  if (found->object < 0 || serial > found->serial) *found = {.object = object, .serial = serial, .total = total};
  return found->total == total ? &*found : nullptr;
}

void ShapeCollector::note(const ObjectShape& shape, Arrival arrival) noexcept {
  NewestShape* newest = find_or_begin(shape.source, shape.object, shape.serial, shape.part.total, arrival);
  if (newest != nullptr && shape.part.number() < newest->received.size()) newest->received.set(shape.part.number());
}

void ShapeCollector::note(const ShapeStart& start, Arrival arrival, std::int64_t now_ns) noexcept {
  NewestShape* newest = find_or_begin(start.source, start.object, start.serial, start.total, arrival);
  if (newest == nullptr || newest->has_begun) return;
  newest->has_begun = true;
  newest->next_request_ns = now_ns + kPartTimeoutNs;
}

// Requests the vertices from the first missing part on.
ShapeStatus ShapeCollector::make_request(const NewestShape& newest) const noexcept {
  std::uint32_t part = 0;
  while (newest.received[part]) ++part;
  return {.source = source_, .serial = newest.serial, .object = newest.object, .first = part * ShapePart::kVerticesPerPart};
}

void ShapeCollector::request_if_due(std::int64_t now_ns) noexcept {
  if (tap_ == nullptr || !tap_->is_recording() || !peers_.has_haptics()) return;
  for (NewestShape& newest : objects_) {
    if (!newest.is_missing() || now_ns < newest.next_request_ns) continue;
    newest.next_request_ns = now_ns + kRequestEveryNs;
    peers_.send_to_role(NodeRole::haptics, make_request(newest));
  }
}

}  // namespace hapton
