#include "recording/shape_index.h"

#include <algorithm>
#include <limits>
#include <ranges>

namespace hapton {
namespace {

constexpr double kBeforeAllS = std::numeric_limits<double>::lowest();

bool is_of(const ShapeStart& start, std::uint32_t source, std::int32_t object, std::uint32_t serial) {
  return start.source == source && start.object == object && start.serial == serial;
}

}  // namespace

// Searches only where parts can still arrive: the last shapes, and the first, which may have begun before the recording.
IndexedShape* ShapeIndex::find_shape(std::uint32_t source, std::int32_t object, std::uint32_t serial) {
  const auto is_match = [&](const Timed<IndexedShape>& one) { return is_of(one.message.start, source, object, serial); };
  const auto last = shapes_.size() > kMaxOpen ? shapes_.end() - static_cast<std::ptrdiff_t>(kMaxOpen) : shapes_.begin();
  if (const auto found = std::find_if(last, shapes_.end(), is_match); found != shapes_.end()) return &found->message;
  const auto first = shapes_.begin() + static_cast<std::ptrdiff_t>(std::min(kMaxFirst, shapes_.size()));
  const auto found = std::find_if(shapes_.begin(), first, is_match);
  return found != first ? &found->message : nullptr;
}

const Timed<IndexedShape>* ShapeIndex::find_newest(std::uint32_t source, std::int32_t object) const {
  for (const Timed<IndexedShape>& one : shapes_ | std::views::reverse) {
    if (one.message.start.source != source) return nullptr;
    if (one.message.start.object == object) return &one;
  }
  return nullptr;
}

// Parts that are sent again at the request of a vision node are left out.
void ShapeIndex::add(const ObjectShape& shape, std::uint64_t position) {
  auto parts = std::ranges::find_if(open_parts_, [&](const Parts& one) {
    return one.source == shape.source && one.object == shape.object && one.serial == shape.serial;
  });
  if (parts == open_parts_.end()) {
    if (const IndexedShape* indexed = find_shape(shape.source, shape.object, shape.serial); indexed != nullptr && indexed->first_position)
      return;
    open_parts_.push_back({.source = shape.source, .serial = shape.serial, .object = shape.object, .first_position = position});
    if (open_parts_.size() > kMaxOpen) open_parts_.pop_front();
    parts = std::prev(open_parts_.end());
  }
  if (shape.part.number() >= parts->received.size() || parts->received[shape.part.number()]) return;
  parts->received.set(shape.part.number());
  parts->last_position = position;
  IndexedShape* indexed = find_shape(shape.source, shape.object, shape.serial);
  if (indexed == nullptr) return;
  indexed->first_position = parts->first_position;
  indexed->last_position = position;
}

// The haptics node repeats the newest start of each object.
void ShapeIndex::add(const ShapeStart& start, double t_s) {
  const bool is_first_process = first_source_ == 0 || first_source_ == start.source;
  const bool is_new_process = !is_first_process && (shapes_.empty() || shapes_.back().message.start.source != start.source);
  if (first_source_ == 0) first_source_ = start.source;
  if (start.serial == 0 && !is_new_process) return;
  const Timed<IndexedShape>* newest = find_newest(start.source, start.object);
  if (newest != nullptr && newest->message.start.serial >= start.serial) return;
  IndexedShape shape{.start = start};
  const auto parts = std::ranges::find_if(open_parts_, [&](const Parts& one) { return is_of(start, one.source, one.object, one.serial); });
  if (parts != open_parts_.end()) {
    shape.first_position = parts->first_position;
    shape.last_position = parts->last_position;
  }
  const bool existed_before_recording =
      is_first_process && newest == nullptr && first_scene_time_ns_ && start.start_ns < *first_scene_time_ns_;
  if (existed_before_recording) {
    shapes_.insert(shapes_.begin(), {kBeforeAllS, shape});
    return;
  }
  shapes_.push_back({shapes_.empty() ? t_s : std::max(t_s, shapes_.back().t_s), shape});
}

void ShapeIndex::add(const ForceCommand& force) {
  if (!first_scene_time_ns_) first_scene_time_ns_ = force.scene_time_ns;
}

const IndexedShape* ShapeIndex::find(std::int32_t object, double t_s, double ahead_s, std::int64_t scene_time_ns) const {
  const std::size_t now = count_until(all(), t_s);
  const std::size_t until = count_until(all(), t_s + ahead_s);
  if (until == 0) return nullptr;
  const std::uint32_t source = shapes_[now > 0 ? now - 1 : 0].message.start.source;
  for (std::size_t i = until; i-- > 0;) {
    const IndexedShape& one = shapes_[i].message;
    if (one.start.source != source) {
      if (i < now) return nullptr;
      continue;
    }
    if (one.start.object != object || one.start.serial == 0) continue;
    if (one.start.start_ns < scene_time_ns) return &one;
  }
  return nullptr;
}

const IndexedShape* ShapeIndex::find_before(const ShapeStart& start) const {
  if (start.before == 0) return nullptr;
  for (const Timed<IndexedShape>& one : shapes_ | std::views::reverse) {
    if (is_of(one.message.start, start.source, start.object, start.before)) return &one.message;
  }
  return nullptr;
}

}  // namespace hapton
