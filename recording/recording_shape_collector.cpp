#include "recording/recording_shape_collector.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/base/ns_between.h"

namespace hapton {
namespace {

constexpr ChangeColumn<RecordedShape> kShapeColumns[] = {
    {"t_s", "s", [](const RecordedShape& r) { return r.t_s; }},
    {"process", "1", [](const RecordedShape& r) { return static_cast<double>(r.process); }},
    {"serial", "1", [](const RecordedShape& r) { return static_cast<double>(r.start.serial); }},
    {"object", "1", [](const RecordedShape& r) { return static_cast<double>(r.start.object); }},
    {"before", "1", [](const RecordedShape& r) { return static_cast<double>(r.start.before); }},
    {"start_scene_time_s", "s", [](const RecordedShape& r) { return 1e-9 * static_cast<double>(r.start.start_ns); }},
    {"end_scene_time_s", "s", [](const RecordedShape& r) { return 1e-9 * static_cast<double>(r.start.end_ns); }},
    {"vertices", "1", [](const RecordedShape& r) { return static_cast<double>(r.start.total); }},
    {"row", "1", [](const RecordedShape& r) { return r.row ? static_cast<double>(*r.row) : std::numeric_limits<double>::quiet_NaN(); }},
};

}  // namespace

std::span<const ChangeColumn<RecordedShape>> shape_columns() noexcept { return kShapeColumns; }

void RecordingShapeCollector::add(const SessionEntry& entry, const Datagram* datagram, const Take& take) {
  if (datagram == nullptr || entry.kind != SessionEntry::Kind::received) return;
  processes_.add(datagram->message);
  if (processes_.number() != process_) begin_process(take);
  if (const auto* part = std::get_if<ObjectShape>(&datagram->message)) {
    if (part->serial <= closed_[part->object]) return;  // sent again at the request of a vision node
    open(part->object, part->serial, part->part.total, take).parts.add(part->part);
  } else if (const auto* start = std::get_if<ShapeStart>(&datagram->message)) {
    // The haptics node repeats the newest ShapeStart of each object.
    if (start->serial <= started_[start->object]) return;
    started_[start->object] = start->serial;
    Open& shape = open(start->object, start->serial, start->total, take);
    shape.is_started = true;
    shape.shape = {.t_s = seconds_between(start_ns_, entry.time_ns),
                   .time_ns = entry.time_ns,
                   .sender = datagram->header.sender,
                   .process = process_,
                   .start = *start};
  } else {
    return;
  }
  hand_on_whole(take);
}

void RecordingShapeCollector::begin_process(const Take& take) {
  finish(take);
  process_ = processes_.number();
  started_.clear();
  closed_.clear();
  rows_.clear();
}

RecordingShapeCollector::Open& RecordingShapeCollector::open(std::int32_t object, std::uint32_t serial, std::uint32_t total,
                                                             const Take& take) {
  const auto found = std::ranges::find_if(open_, [&](const Open& one) { return one.object == object && one.serial == serial; });
  if (found != open_.end()) return *found;
  if (open_.size() == kMaxOpen) close_first(take);
  open_.push_back({.object = object, .serial = serial, .parts = ShapeParts(std::min(total, ShapePart::kMaxVertices))});
  return open_.back();
}

// A shape without a ShapeStart was never applied, and is dropped.
void RecordingShapeCollector::close_first(const Take& take) {
  Open& one = open_.front();
  if (one.is_started) {
    const bool is_whole = one.parts.total() == one.shape.start.total && one.parts.is_whole();
    one.shape.displacements_m = is_whole ? one.parts.displacements_m() : std::span<const ShapePart::Displacement>();
    one.shape.row = take_row(one.shape);
    take(one.shape);
    std::uint32_t& closed = closed_[one.object];
    closed = std::max(closed, one.serial);
  }
  open_.pop_front();
}

std::optional<std::uint64_t> RecordingShapeCollector::take_row(const RecordedShape& shape) {
  if (shape.displacements_m.empty()) return std::nullopt;
  Rows& rows = rows_[shape.start.object];
  if (rows.count == 0) rows.vertices = shape.displacements_m.size();
  return rows.vertices == shape.displacements_m.size() ? std::optional(rows.count++) : std::nullopt;
}

// Shapes are handed on in order: a shape that is not complete holds back later ones.
void RecordingShapeCollector::hand_on_whole(const Take& take) {
  while (!open_.empty() && open_.front().is_started && open_.front().parts.is_whole()) close_first(take);
}

void RecordingShapeCollector::finish(const Take& take) {
  while (!open_.empty()) close_first(take);
}

}  // namespace hapton
