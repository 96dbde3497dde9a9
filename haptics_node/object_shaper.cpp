#include "haptics_node/object_shaper.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "haptic_step/haptics_setup.h"
#include "link/wire_text.h"
#include "runtime/start_thread.h"

namespace hapton {
namespace {

// Programs that know shapes from messages only have room for at least as many.
static_assert(ProgramShape::kMaxObjects <= ShapePart::kMaxObjects);
static_assert(ProgramShape::kMaxVertices <= ShapePart::kMaxVertices);

// The time between two polls for shapes: a small part of the time between two shapes.
constexpr std::chrono::milliseconds kShapePollPeriod(2);
constexpr std::int64_t kLossyNs = 10 * kNanosecondsPerSecond;  // parts count as getting lost for this time after one was requested again
constexpr std::int64_t kMaxAtOnce = 4;                         // paced parts that may be sent at once after a pause

}  // namespace

ObjectShaper::Object::Object(std::int32_t number, const SceneObject& object, StreamedMethod& streamed, std::uint32_t source)
    : name(object.name),
      method(&streamed),
      maker(streamed, *object.program_shape),
      parts(static_cast<std::uint32_t>(object.mesh->vertices.size())),
      previous_parts(parts.total()),
      start{.source = source, .object = number, .total = parts.total()},
      resend_from(parts.total()) {}

ObjectShaper::ObjectShaper(const Scene& scene, const TouchStep& touch, std::uint32_t source) {
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    const auto number = static_cast<std::int32_t>(o);
    names_.push_back(scene.objects[o].name);
    if (scene.objects[o].program_shape == nullptr) continue;
    if (StreamedMethod* streamed = touch.find_streamed(number); streamed != nullptr) {
      objects_.push_back(std::make_unique<Object>(number, scene.objects[o], *streamed, source));
    }
  }
  for (const auto& object : objects_) object->has_unique_name = std::count(names_.begin(), names_.end(), object->name) == 1;
}

ObjectShaper::~ObjectShaper() {
  stop_ = true;
  if (thread_.joinable()) thread_.join();
}

void ObjectShaper::start() {
  thread_ = start_thread([this] { run(); });
}

void ObjectShaper::run() {
  // Polls instead of waiting: waking a sleeping thread would be a system call in the real-time loop.
  while (!stop_.load()) {
    if (!work()) std::this_thread::sleep_for(kShapePollPeriod);
  }
}

bool ObjectShaper::work() {
  bool has_work = false;
  for (const auto& object : objects_) has_work = object->maker.work() || has_work;
  return has_work;
}

std::string_view ObjectShaper::name_of(std::int32_t object) const noexcept {
  return static_cast<std::size_t>(object) < names_.size() ? std::string_view(names_[static_cast<std::size_t>(object)]) : "";
}

ObjectShaper::Object* ObjectShaper::find(const ShapeRequest& part) noexcept {
  const std::string_view name = text_of(part.object);
  const auto is_it = [&](const std::unique_ptr<Object>& one) {
    return name.empty() ? one->start.object == part.number : one->has_unique_name && one->name == name;
  };
  const auto found = std::find_if(objects_.begin(), objects_.end(), is_it);
  return found != objects_.end() ? found->get() : nullptr;
}

// Why find() finds no object for this part.
std::string_view ObjectShaper::explain(const ShapeRequest& part) const noexcept {
  const std::string_view name = text_of(part.object);
  const bool is_number = name.empty() && static_cast<std::size_t>(part.number) < names_.size();
  const auto count = is_number ? 1 : std::count(names_.begin(), names_.end(), name);
  if (count == 0) return "no object of the scene has that name or number; hapton info lists them";
  if (count > 1) return "several objects have that name; give the number of one";
  return "programs may not deform this object; give it deformed_by = \"program\" and reach_m in the scene file";
}

void ObjectShaper::push_reply(const ShapeReply& reply) noexcept {
  if (reply_count_ == kMaxReplies) return;  // its sender repeats the shape
  replies_[(first_reply_ + reply_count_++) % kMaxReplies] = reply;
}

void ObjectShaper::reject(const ShapeRequest& part, std::int32_t object, std::string_view why, std::int64_t now_ns) noexcept {
  ++counts_.rejected;
  if (now_ns < next_rejection_ns_) return;
  next_rejection_ns_ = now_ns + kRejectEveryNs;
  ShapeReply reply{.stream = part.stream, .shape = part.shape, .object = object};
  put_text(why, reply.rejection);
  push_reply(reply);
}

void ObjectShaper::accept(const ShapeRequest& part, std::int64_t now_ns) noexcept {
  Object* object = find(part);
  // A flood of such parts is only counted: while no reply is due, the reason is not determined.
  if (object == nullptr) return reject(part, 0, now_ns < next_rejection_ns_ ? std::string_view() : explain(part), now_ns);
  const std::int32_t number = object->start.object;
  if (part.part.total != object->parts.total()) {
    return reject(part, number, "the shape has another number of vertices than the mesh; hapton info shows the mesh's number", now_ns);
  }
  if (object->stream != part.stream) {
    if (object->stream != 0 && now_ns - object->last_part_ns < kSilentNs) {
      return reject(part, number, "another program deforms this object; it can be replaced 1 s after its last shape", now_ns);
    }
    object->stream = part.stream;
    object->shape = 0;
    object->is_passed_on = false;
    object->parts.clear();
    object->previous_parts.clear();
  }
  object->last_part_ns = now_ns;
  if (part.shape < object->shape) return add_overtaken(*object, part);
  if (part.shape == object->shape && object->is_passed_on) {
    const bool is_repeat = part.part.first == 0 && object->reply.stream == part.stream && object->reply.shape == part.shape;
    if (is_repeat) push_reply(object->reply);
    return;
  }
  if (part.shape != object->shape) begin_shape(*object, part.shape);
  object->parts.add(part.part);
  if (!object->parts.is_whole()) return;
  pass_on(*object, part, object->parts);
  object->is_passed_on = true;
  drop_previous_shape(*object);
}

// The shape before may still become complete, because parts may overtake one another.
void ObjectShaper::begin_shape(Object& object, std::uint32_t shape) noexcept {
  drop_previous_shape(object);
  if (!object.is_passed_on) {
    std::swap(object.previous_parts, object.parts);
    object.previous_shape = object.shape;
  }
  object.parts.clear();
  object.shape = shape;
  object.is_passed_on = false;
}

void ObjectShaper::add_overtaken(Object& object, const ShapeRequest& part) noexcept {
  if (object.previous_parts.is_empty() || part.shape != object.previous_shape) return;  // that shape was left out, or is complete
  object.previous_parts.add(part.part);
  if (!object.previous_parts.is_whole()) return;
  pass_on(object, part, object.previous_parts);
  object.previous_parts.clear();
}

void ObjectShaper::drop_previous_shape(Object& object) noexcept {
  counts_.incomplete += object.previous_parts.is_empty() ? 0 : 1;
  object.previous_parts.clear();
}

void ObjectShaper::pass_on(Object& object, const ShapeRequest& part, const ShapeParts& parts) noexcept {
  WantedShape& draft = object.maker.draft();
  draft.stream = part.stream;
  draft.shape = part.shape;
  draft.over_s = part.over_s;
  std::copy(parts.displacements_m().begin(), parts.displacements_m().end(), draft.displacements_m.begin());
  object.maker.publish();
}

void ObjectShaper::accept(const ShapeStatus& status, std::int64_t now_ns) noexcept {
  for (const auto& object : objects_) {
    if (object->start.object != status.object || object->start.source != status.source) continue;
    if (status.count == 0 && object->start.serial == status.serial) object->resend_from = std::min(object->resend_from, status.first);
    if (status.count == 0) continue;
    lossy_until_ns_ = now_ns + kLossyNs;
    const std::uint32_t end = std::min(status.first + status.count, object->start.total);
    if (resends_end_ - resends_begin_ < kMaxResends)
      resends_[resends_end_++ % kMaxResends] = {object.get(), status.serial, status.first, end};
  }
}

// A part that the hub has requested again. Requests for shapes that are no longer kept are dropped.
std::optional<Message> ObjectShaper::take_resend(std::int64_t now_ns) noexcept {
  for (; resends_begin_ != resends_end_; ++resends_begin_) {
    Resend& resend = resends_[resends_begin_ % kMaxResends];
    const auto& announced = resend.object->announced;
    const auto is_it = [&](const Object::Announced& one) { return one.serial == resend.serial && one.made != nullptr; };
    const auto found = std::find_if(announced.begin(), announced.end(), is_it);
    if (found == announced.end() || resend.first >= resend.end) continue;
    const std::uint32_t first = std::exchange(resend.first, resend.first + ShapePart::kVerticesPerPart);
    return make_part(*resend.object, resend.serial, found->made->wanted, first, now_ns);
  }
  return std::nullopt;
}

void ObjectShaper::take_rejection(Object& object) noexcept {
  const RejectedShape* rejected = object.maker.take_rejection();
  if (rejected == nullptr) return;
  ++counts_.rejected;
  object.reply = {.stream = rejected->stream, .shape = rejected->shape, .rejection = rejected->why, .object = object.start.object};
  push_reply(object.reply);
}

// The time that the hub gets to make a shape ready.
std::int64_t ObjectShaper::find_stage_ns(const Object& object) const noexcept {
  if (pace_.lead_ns == 0) return 0;
  return std::clamp(2 * pace_.stage_ns_per_vertex, kMinStageNsPerVertex, kMaxStageNsPerVertex) * object.start.total;
}

std::int64_t ObjectShaper::find_lead_ns(const Object& object) const noexcept {
  if (pace_.lead_ns == 0) return 0;
  return pace_.lead_ns + (is_lossy_ ? pace_.resend_ns : 0) + find_stage_ns(object);
}

// The shortest time of a motion, so that the surface does not stop between two: the limit of waiting motions must suffice for the lead,
// each shape takes time to be sent, and to be made ready by a hub that spends at most half of its time on shapes.
double ObjectShaper::find_min_duration_s(const Object& object) const noexcept {
  const std::int64_t of_queue_ns = find_lead_ns(object) / static_cast<std::int64_t>(StreamedMethod::kMaxWaiting - 1);
  const std::int64_t of_parts_ns = ShapePart::count_parts(object.start.total) * pace_.part_ns;
  return 1e-9 * static_cast<double>(std::max({of_queue_ns, of_parts_ns, find_stage_ns(object)}));
}

bool ObjectShaper::has_room(const Object& object) const noexcept {
  return object.method->waiting() < (pace_.lead_ns > 0 ? StreamedMethod::kMaxWaiting : 1);
}

bool ObjectShaper::begin_sending(Object& object, std::int64_t scene_time_ns) noexcept {
  if (object.start.end_ns > scene_time_ns + kSendAheadNs + find_lead_ns(object)) return false;
  object.next = object.maker.take();
  if (object.next == nullptr) return false;
  object.sent_until = 0;
  sending_ = &object;
  ++serial_;
  return true;
}

Message ObjectShaper::begin_motion(Object& object, HapticsStep& step) noexcept {
  const double over_s =
      StreamedMethod::compute_time_s(*object.next->stage, std::max(object.next->wanted.over_s, find_min_duration_s(object)));
  ShapeStart& start = object.start;
  start.before = start.serial;
  start.serial = serial_;
  start.start_ns = std::max(start.end_ns, step.scene_time_ns() + 1 + find_lead_ns(object));
  start.end_ns = start.start_ns + static_cast<std::int64_t>(std::ceil(1e9 * over_s));
  auto used = step.deform(start.object, std::move(object.next->stage), start.start_ns, start.end_ns);
  Object::Announced& place = object.announced[object.announced_count++ % kMaxAnnounced];
  (place.made != nullptr ? place.made : object.next)->stage = std::move(used);
  if (place.made != nullptr) object.maker.give_back(std::move(place.made));
  place = {serial_, std::move(object.next)};
  object.resend_from = start.total;
  object.reply = {.stream = place.made->wanted.stream,
                  .shape = place.made->wanted.shape,
                  .object = start.object,
                  .over_s = 1e-9 * static_cast<double>(start.end_ns - start.start_ns),
                  .serial = start.serial};
  push_reply(object.reply);
  ++counts_.shapes;
  newest_start_ = &start;
  sending_ = nullptr;
  return start;
}

Message ObjectShaper::make_part(const Object& object, std::uint32_t serial, const WantedShape& shape, std::uint32_t first,
                                std::int64_t now_ns) noexcept {
  next_part_ns_ = std::max(next_part_ns_, now_ns - kMaxAtOnce * pace_.part_ns) + pace_.part_ns;
  return ObjectShape{.source = object.start.source,
                     .serial = serial,
                     .object = object.start.object,
                     .part = make_shape_part(shape.displacements_m, first)};
}

std::optional<Message> ObjectShaper::take_due(HapticsStep& step, std::int64_t now_ns) noexcept {
  for (const auto& object : objects_) take_rejection(*object);
  is_lossy_ = now_ns < lossy_until_ns_;
  if (reply_count_ > 0) {
    const ShapeReply& reply = replies_[first_reply_];
    first_reply_ = (first_reply_ + 1) % kMaxReplies;
    --reply_count_;
    return reply;
  }
  for (std::size_t looked = 0; looked < objects_.size() && sending_ == nullptr; ++looked) {
    Object& object = *objects_[next_object_];
    next_object_ = (next_object_ + 1) % objects_.size();
    begin_sending(object, step.scene_time_ns());
  }
  const bool is_whole = sending_ == nullptr || sending_->sent_until >= sending_->start.total;
  // All parts are sent, and few enough motions wait that this one can wait, too.
  if (sending_ != nullptr && is_whole && has_room(*sending_)) return begin_motion(*sending_, step);
  if (now_ns < next_part_ns_) return std::nullopt;
  if (auto resend = take_resend(now_ns)) return resend;
  if (!is_whole) {
    const std::uint32_t first = std::exchange(sending_->sent_until, sending_->sent_until + ShapePart::kVerticesPerPart);
    return make_part(*sending_, serial_, sending_->next->wanted, first, now_ns);
  }
  for (const auto& object : objects_) {
    if (object->resend_from >= object->start.total || object->announced_count == 0) continue;
    const std::uint32_t first = std::exchange(object->resend_from, object->resend_from + ShapePart::kVerticesPerPart);
    return make_part(*object, object->start.serial, object->present().made->wanted, first, now_ns);
  }
  return std::nullopt;
}

}  // namespace hapton
