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
    if (part->serial <= passed_serials_[part->object]) return;  // sent again at the request of a vision node
    find_or_add(part->object, part->serial, part->part.total, take).parts.add(part->part);
  } else if (const auto* start = std::get_if<ShapeStart>(&datagram->message)) {
    // The haptics node repeats the newest ShapeStart of each object.
    if (start->serial <= started_serials_[start->object]) return;
    started_serials_[start->object] = start->serial;
    PendingShape& shape = find_or_add(start->object, start->serial, start->total, take);
    shape.is_started = true;
    shape.shape = {.t_s = seconds_between(start_ns_, entry.time_ns),
                   .time_ns = entry.time_ns,
                   .sender = datagram->header.sender,
                   .process = process_,
                   .start = *start};
  } else {
    return;
  }
  pass_whole(take);
}

void RecordingShapeCollector::begin_process(const Take& take) {
  finish(take);
  process_ = processes_.number();
  started_serials_.clear();
  passed_serials_.clear();
  rows_.clear();
}

RecordingShapeCollector::PendingShape& RecordingShapeCollector::find_or_add(std::int32_t object, std::uint32_t serial, std::uint32_t total,
                                                                            const Take& take) {
  const auto found = std::ranges::find_if(pending_, [&](const PendingShape& one) { return one.object == object && one.serial == serial; });
  if (found != pending_.end()) return *found;
  if (pending_.size() == kMaxPending) pass_first(take);
  pending_.push_back({.object = object, .serial = serial, .parts = ShapeParts(std::min(total, ShapePart::kMaxVertices))});
  return pending_.back();
}

// A shape without a ShapeStart was never applied, and is dropped.
void RecordingShapeCollector::pass_first(const Take& take) {
  PendingShape& one = pending_.front();
  if (one.is_started) {
    const bool is_whole = one.parts.total() == one.shape.start.total && one.parts.is_whole();
    one.shape.displacements_m = is_whole ? one.parts.displacements_m() : std::span<const ShapePart::Displacement>();
    one.shape.row = take_row(one.shape);
    take(one.shape);
    std::uint32_t& passed_serial = passed_serials_[one.object];
    passed_serial = std::max(passed_serial, one.serial);
  }
  pending_.pop_front();
}

std::optional<std::uint64_t> RecordingShapeCollector::take_row(const RecordedShape& shape) {
  if (shape.displacements_m.empty()) return std::nullopt;
  Rows& rows = rows_[shape.start.object];
  if (rows.count == 0) rows.vertices = shape.displacements_m.size();
  return rows.vertices == shape.displacements_m.size() ? std::optional(rows.count++) : std::nullopt;
}

// Shapes are handed on in order: a shape that is not complete holds back later ones.
void RecordingShapeCollector::pass_whole(const Take& take) {
  while (!pending_.empty() && pending_.front().is_started && pending_.front().parts.is_whole()) pass_first(take);
}

void RecordingShapeCollector::finish(const Take& take) {
  while (!pending_.empty()) pass_first(take);
}

}  // namespace hapton
