#include "link/known_shapes.h"

#include <algorithm>
#include <span>

namespace hapton {

KnownShapes::KnownShapes(const std::vector<std::uint32_t>& totals) {
  for (std::size_t o = 0; o < totals.size(); ++o) {
    if (totals[o] != 0) add_object(o, totals[o]);
  }
}

void KnownShapes::add_object(std::size_t object, std::uint32_t total) {
  Object& record = objects_[object];
  if (record.total != total) record = {.total = total};
}

void KnownShapes::keep_objects(const std::set<std::size_t>& objects) {
  std::erase_if(objects_, [&](const auto& one) { return !objects.contains(one.first); });
}

KnownShapes::Object* KnownShapes::find_object(std::int32_t object, std::uint32_t total) {
  const auto found = object >= 0 ? objects_.find(static_cast<std::size_t>(object)) : objects_.end();
  return found != objects_.end() && found->second.total == total ? &found->second : nullptr;
}

const KnownShapes::Object* KnownShapes::find_object(std::size_t object) const {
  const auto found = objects_.find(object);
  return found != objects_.end() ? &found->second : nullptr;
}

bool KnownShapes::note_source(std::uint32_t source, Arrival arrival) {
  const HapticsSource::Verdict verdict = source_.note(source, arrival);
  if (verdict == HapticsSource::Verdict::old) return false;
  if (verdict == HapticsSource::Verdict::other) {
    for (auto& [number, object] : objects_) object = {.total = object.total};
  }
  process_ = source;
  return true;
}

void KnownShapes::take(const ObjectShape& shape, Arrival arrival) {
  Object* const found = find_object(shape.object, shape.part.total);
  if (found == nullptr || !note_source(shape.source, arrival)) return;
  Object& object = *found;
  const bool is_outdated = !object.starts.empty() && shape.serial < object.starts.front().serial;
  if (is_outdated) return;
  object.shapes.try_emplace(shape.serial, shape.part.total).first->second.add(shape.part);
  if (object.shapes.size() > kMaxShapes) object.shapes.erase(object.shapes.begin());
}

void KnownShapes::take(const ShapeStart& start, Arrival arrival) {
  Object* const found = find_object(start.object, start.total);
  if (found == nullptr || !note_source(start.source, arrival) || start.serial == 0) return;
  Object& object = *found;
  const auto after = std::find_if(object.starts.begin(), object.starts.end(), [&](const auto& one) { return one.serial >= start.serial; });
  if (after != object.starts.end() && after->serial == start.serial) return;
  if (after == object.starts.end()) object.request_ns = 0;
  object.starts.insert(after, start);
  if (object.starts.size() > kMaxStarts) object.starts.pop_front();
  std::uint32_t oldest = start.before;
  for (const ShapeStart& one : object.starts) oldest = std::min(oldest, one.before);
  object.shapes.erase(object.shapes.begin(), object.shapes.lower_bound(oldest));
}

const ShapeParts* KnownShapes::find_whole(const Object& object, std::uint32_t serial) const {
  const auto found = object.shapes.find(serial);
  return found != object.shapes.end() && found->second.is_whole() ? &found->second : nullptr;
}

std::optional<KnownShapes::Place> KnownShapes::find(std::size_t object, std::int64_t scene_time_ns) const {
  const Object* const found = find_object(object);
  if (found == nullptr) return std::nullopt;
  const Object& record = *found;
  if (record.starts.empty()) return Place();  // no shape has been announced: the object is at rest
  const ShapeStart* start = &record.starts.front();
  for (const ShapeStart& one : record.starts) {
    if (one.start_ns < scene_time_ns) start = &one;
  }
  const std::int64_t passed_ns = scene_time_ns - start->start_ns;
  const std::int64_t duration_ns = start->end_ns - start->start_ns;
  const double share = passed_ns <= 0             ? 0.0
                       : passed_ns >= duration_ns ? 1.0
                                                  : static_cast<double>(passed_ns) / static_cast<double>(duration_ns);
  const bool knows_before = is_known(record, start->before);
  const bool knows_to = is_known(record, start->serial);
  if (knows_before && knows_to) return Place{start->before, start->serial, share};
  if (knows_to) return Place{start->serial, start->serial, 1.0};
  if (knows_before) return Place{start->before, start->before, 1.0};
  return std::nullopt;
}

const ShapeStart* KnownShapes::newest_start(std::size_t object) const {
  const Object* const record = find_object(object);
  return record != nullptr && !record->starts.empty() ? &record->starts.back() : nullptr;
}

const ShapeStart* KnownShapes::find_start(std::size_t object, std::uint32_t serial) const {
  const Object* const record = find_object(object);
  if (record == nullptr) return nullptr;
  const auto found =
      std::find_if(record->starts.begin(), record->starts.end(), [&](const ShapeStart& one) { return one.serial == serial; });
  return found != record->starts.end() ? &*found : nullptr;
}

const ShapeStart* KnownShapes::find_next(std::size_t object, std::uint32_t serial, std::int64_t scene_time_ns) const {
  const Object* const record = find_object(object);
  const ShapeStart* next = nullptr;
  for (std::size_t n = 0; record != nullptr && n < record->starts.size(); ++n) {
    const ShapeStart& start = record->starts[n];
    if (start.serial <= serial || find_whole(*record, start.serial) == nullptr) continue;
    next = &start;
    if (start.end_ns > scene_time_ns) break;
  }
  return next;
}

std::vector<ShapePart::Displacement> KnownShapes::displacements_m(std::size_t object, const Place& place) const {
  const Object& record = objects_.at(object);
  const std::vector<ShapePart::Displacement> at_rest(record.total);
  const auto shape_of = [&](std::uint32_t serial) {
    return serial == 0 ? std::span<const ShapePart::Displacement>(at_rest) : record.shapes.at(serial).displacements_m();
  };
  const auto before = shape_of(place.before);
  const auto to = shape_of(place.to);
  std::vector<ShapePart::Displacement> displaced(to.begin(), to.end());
  if (place.share >= 1.0) return displaced;
  const auto share = static_cast<float>(place.share);
  for (std::size_t v = 0; v < displaced.size(); ++v) {
    for (std::size_t k = 0; k < 3; ++k) displaced[v][k] = before[v][k] + share * (to[v][k] - before[v][k]);
  }
  return displaced;
}

std::optional<ShapeStatus> KnownShapes::take_request(std::int64_t now_ns) {
  for (auto& [o, object] : objects_) {
    if (object.starts.empty()) continue;
    const std::uint32_t serial = object.starts.back().serial;
    if (find_whole(object, serial) != nullptr) continue;
    if (object.request_ns == 0) object.request_ns = now_ns + kPartTimeoutNs;
    if (now_ns < object.request_ns) continue;
    object.request_ns = now_ns + kRequestEveryNs;
    const auto part = object.shapes.find(serial);
    return ShapeStatus{.source = process_,
                       .serial = serial,
                       .object = static_cast<std::int32_t>(o),
                       .first = part != object.shapes.end() ? part->second.first_missing() : 0};
  }
  return std::nullopt;
}

// Requests each run of missing parts; the last run for which there is room extends to the end of the shape.
void KnownShapes::request_runs(std::size_t object, const ShapeStart& start, const ShapeParts* parts, std::vector<ShapeStatus>& into) const {
  const std::uint32_t all = ShapePart::count_parts(start.total);
  const auto is_missing = [&](std::uint32_t part) { return parts == nullptr || !parts->has(part); };
  std::size_t runs = 0;
  for (std::uint32_t part = 0; part < all && runs < kMaxRuns; ++part) {
    if (!is_missing(part)) continue;
    const std::uint32_t first = part;
    while (part < all && is_missing(part)) ++part;
    if (++runs == kMaxRuns) part = all;
    into.push_back({.source = process_,
                    .serial = start.serial,
                    .object = static_cast<std::int32_t>(object),
                    .first = first * ShapePart::kVerticesPerPart,
                    .count = (part - first) * ShapePart::kVerticesPerPart});
  }
}

void KnownShapes::take_requests_ahead(std::int64_t now_ns, std::vector<ShapeStatus>& into) {
  for (auto& [number, object] : objects_) {
    if (object.starts.empty()) continue;
    object.request_ahead_ns.erase(object.request_ahead_ns.begin(), object.request_ahead_ns.lower_bound(object.starts.front().serial));
    for (const ShapeStart& start : object.starts) {
      const auto [due, is_new] = object.request_ahead_ns.try_emplace(start.serial, now_ns + kReorderedNs);
      if (is_new || due->second == 0 || now_ns < due->second) continue;
      due->second = 0;
      const auto parts = object.shapes.find(start.serial);
      const ShapeParts* const known = parts != object.shapes.end() ? &parts->second : nullptr;
      if (known == nullptr || !known->is_whole()) request_runs(number, start, known, into);
    }
  }
}

}  // namespace hapton
