#include "tools/session/recorded_shapes.h"

#include <algorithm>
#include <utility>

namespace hapton {
namespace {

// Starts a motion whose two shapes are known, as a stage of the surface in this step.
bool begin_stage(HapticsStep& step, const ShapeStart& start, std::span<const Vec3> from, std::span<const Vec3> to) {
  StreamedMethod* method = step.touch().find_streamed(start.object);
  auto stage = method->stager().make(from, to);
  if (!stage) return false;
  (void)step.deform(start.object, std::move(*stage), start.start_ns, start.end_ns);
  return true;
}

}  // namespace

void RecordedShapes::add(std::uint64_t sender, const ObjectShape& shape) {
  SenderShapes& sender_shapes = senders_[sender];
  // This shape has been applied already; it was only sent again to a vision node.
  if (shape.serial <= sender_shapes.applied_serial) return;
  sender_shapes.shapes.try_emplace(shape.serial, shape.part.total).first->second.add(shape.part);
}

void RecordedShapes::add(std::uint64_t sender, const ShapeStart& start) {
  SenderShapes& sender_shapes = senders_[sender];
  if (start.serial > sender_shapes.applied_serial) sender_shapes.starts[start.serial] = start;
}

void RecordedShapes::push(SenderShapes& sender_shapes, BegunMotion begun) {
  std::deque<BegunMotion>& all = sender_shapes.begun_motions[begun.start.object];
  all.push_back(std::move(begun));
  if (all.size() > 2) all.pop_front();
}

void RecordedShapes::begin(std::uint64_t sender, std::uint32_t serial) {
  SenderShapes& sender_shapes = senders_[sender];
  sender_shapes.shapes.erase(sender_shapes.shapes.begin(), sender_shapes.shapes.upper_bound(serial));
  sender_shapes.starts.erase(sender_shapes.starts.begin(), sender_shapes.starts.upper_bound(serial));
  sender_shapes.applied_serial = serial;
  sender_shapes.begun_motions.clear();
  const FirstShapes::SenderShapes* first = first_.find(sender);
  if (first == nullptr) return;
  for (const auto& [key, start] : first->starts) {
    const auto shape = first->shapes.find(start.serial);
    const bool is_whole = shape != first->shapes.end() && shape->second.is_whole() && shape->second.total() == start.total;
    push(sender_shapes, {start, is_whole ? std::optional(shape->second) : std::nullopt});
  }
}

// Moves the motion with this serial to those that have begun. Null: the recording lacks its start, so it may be of any object.
const RecordedShapes::BegunMotion* RecordedShapes::begin_motion(SenderShapes& sender_shapes, std::uint32_t serial) {
  auto shape = sender_shapes.shapes.extract(serial);
  const auto start = sender_shapes.starts.extract(serial);
  sender_shapes.applied_serial = serial;
  if (start.empty()) {
    sender_shapes.begun_motions.clear();
    return nullptr;
  }
  const bool is_whole = !shape.empty() && shape.mapped().is_whole() && shape.mapped().total() == start.mapped().total;
  push(sender_shapes, {start.mapped(), is_whole ? std::optional(std::move(shape.mapped())) : std::nullopt});
  return &sender_shapes.begun_motions[start.mapped().object].back();
}

bool RecordedShapes::apply(std::uint64_t sender, std::uint32_t serial, HapticsStep& step, const FindShape& find_shape) {
  const BegunMotion* begun = begin_motion(senders_[sender], serial);
  if (begun == nullptr || !begun->shape) return false;
  const StreamedMethod* method = step.touch().find_streamed(begun->start.object);
  const auto program_shape = find_shape(begun->start.object);
  if (method == nullptr || program_shape == nullptr || method->waiting() == StreamedMethod::kMaxWaiting) return false;
  const auto rest = method->stager().rest();
  if (rest.size() != begun->shape->total()) return false;
  return begin_stage(step, begun->start, method->newest_stage().to, program_shape->vertices_of(rest, begun->shape->displacements_m()));
}

void RecordedShapes::skip_to(std::uint64_t sender, std::uint32_t serial) {
  SenderShapes& sender_shapes = senders_[sender];
  const auto next = [&] { return sender_shapes.starts.upper_bound(sender_shapes.applied_serial); };
  for (auto start = next(); start != sender_shapes.starts.end() && start->first <= serial; start = next()) {
    if (start->first != sender_shapes.applied_serial + 1)
      sender_shapes.begun_motions.clear();  // a start is missing: the same as in begin_motion()
    (void)begin_motion(sender_shapes, start->first);
  }
  if (sender_shapes.applied_serial != serial) (void)begin_motion(sender_shapes, serial);
  sender_shapes.shapes.erase(sender_shapes.shapes.begin(), sender_shapes.shapes.upper_bound(serial));
}

std::optional<RecordedShapes::Motion> RecordedShapes::find_motion(const SenderShapes& sender_shapes, int object,
                                                                  std::int64_t scene_time_ns) {
  const auto found = sender_shapes.begun_motions.find(object);
  if (found == sender_shapes.begun_motions.end()) return std::nullopt;
  Motion motion{.last = &found->second.back()};
  const ShapeStart& start = motion.last->start;
  if (start.serial == 0) return motion;
  if (!motion.last->shape || scene_time_ns < start.start_ns) return std::nullopt;
  if (start.before == 0 || scene_time_ns >= start.end_ns) return motion;
  const BegunMotion& before = found->second.front();
  if (before.start.serial != start.before || !before.shape) return std::nullopt;
  motion.before = &before;
  return motion;
}

bool RecordedShapes::knows(std::uint64_t sender, std::span<const int> objects, std::int64_t scene_time_ns) const {
  const auto sender_shapes = senders_.find(sender);
  if (sender_shapes == senders_.end()) return false;
  return std::all_of(objects.begin(), objects.end(),
                     [&](int object) { return find_motion(sender_shapes->second, object, scene_time_ns).has_value(); });
}

bool RecordedShapes::restore(std::uint64_t sender, std::span<const int> objects, std::int64_t scene_time_ns, HapticsStep& step,
                             const FindShape& find_shape) const {
  const SenderShapes& sender_shapes = senders_.at(sender);
  for (const int object : objects) {
    const std::optional<Motion> motion = find_motion(sender_shapes, object, scene_time_ns);
    const auto program_shape = find_shape(object);
    if (!motion || program_shape == nullptr) return false;
    const ShapeStart& start = motion->last->start;
    if (start.serial == 0) continue;
    const auto rest = step.touch().find_streamed(object)->stager().rest();
    const auto vertices_of = [&](const ShapeParts& shape) { return program_shape->vertices_of(rest, shape.displacements_m()); };
    if (rest.size() != start.total) return false;
    const std::vector<Vec3> to = vertices_of(*motion->last->shape);
    // Once the motion has ended, it does not matter from which shape it started.
    std::vector<Vec3> from = to;
    if (scene_time_ns < start.end_ns)
      from = motion->before != nullptr ? vertices_of(*motion->before->shape) : std::vector(rest.begin(), rest.end());
    if (!begin_stage(step, start, from, to)) return false;
  }
  return true;
}

}  // namespace hapton
