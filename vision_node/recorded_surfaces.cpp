#include "vision_node/recorded_surfaces.h"

#include <algorithm>

#include "vision_node/recorded_objects.h"

namespace hapton {
namespace {

// Whether the wanted shape is the shown one or follows it, so that what was loaded can be kept.
bool is_next(const IndexedShape* shown, const IndexedShape* wanted) {
  if (shown == nullptr) return true;
  return wanted != nullptr && wanted->start.source == shown->start.source && wanted->start.serial >= shown->start.serial;
}

}  // namespace

RecordedSurfaces::RecordedSurfaces(const RecordingIndex& index, RecordingShapes& shapes, MovedObjects& moved)
    : index_(index), shapes_(shapes), moved_(moved), shown_shapes_(moved.count_objects()) {}

void RecordedSurfaces::show(double t_s, std::int64_t scene_time_ns) {
  if (index_.shapes().all().empty()) return;
  std::vector<const IndexedShape*> wanted(shown_shapes_.size());
  for (std::size_t o = 0; o < wanted.size(); ++o) {
    wanted[o] = index_.shapes().find(static_cast<std::int32_t>(o), t_s, RecordedObjects::kAheadS, scene_time_ns);
  }
  const bool goes_on = std::equal(shown_shapes_.begin(), shown_shapes_.end(), wanted.begin(), is_next);
  if (!goes_on) {
    moved_.forget_shapes();
    std::fill(shown_shapes_.begin(), shown_shapes_.end(), nullptr);
  }
  for (std::size_t o = 0; o < wanted.size(); ++o) {
    if (wanted[o] != nullptr && wanted[o] != shown_shapes_[o]) load(*wanted[o]);
    shown_shapes_[o] = wanted[o];
  }
}

void RecordedSurfaces::load(const IndexedShape& shape) {
  const auto object = static_cast<std::size_t>(shape.start.object);
  const bool has_before = shown_shapes_[object] != nullptr && shown_shapes_[object]->start.serial == shape.start.before;
  const IndexedShape* before = has_before ? nullptr : index_.shapes().find_before(shape.start);
  if (before != nullptr) {
    for (const ObjectShape& part : shapes_.read(*before)) moved_.take(part, Arrival::newest);
  }
  for (const ObjectShape& part : shapes_.read(shape)) moved_.take(part, Arrival::newest);
  moved_.take(shape.start, Arrival::newest);
}

}  // namespace hapton
