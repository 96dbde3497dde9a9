#include "haptic_step/object_mover.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "haptic_step/haptics_setup.h"
#include "link/commanded_move.h"
#include "link/wire_text.h"
#include "scene/object_motion.h"

namespace hapton {
namespace {

// Formats without heap; a text that is too long is cut off.
template <class... Args>
void format_into(HapticsSetup::Text& into, fmt::format_string<Args...> text, Args&&... args) noexcept {
  std::array<char, std::tuple_size_v<HapticsSetup::Text> - 1> line;
  const auto end = fmt::format_to_n(line.data(), line.size(), text, std::forward<Args>(args)...);
  put_text({line.data(), std::min(end.size, line.size())}, into);
}

bool is_before(const std::pair<std::string_view, std::int32_t>& one, std::string_view name) noexcept { return one.first < name; }

}  // namespace

ObjectMover::ObjectMover(const Scene& scene, std::uint32_t source) {
  names_.reserve(scene.objects.size());  // by_name_ has views of them
  for (const SceneObject& object : scene.objects) {
    const auto number = static_cast<std::int32_t>(names_.size());
    names_.push_back(object.name);
    objects_.push_back(object.commanded);
    by_name_.emplace_back(names_.back(), number);
    if (object.commanded == nullptr) continue;
    const Vec3& pivot = object.commanded->pivot();
    moves_.push_back({.source = source, .object = number, .from_p_m = pivot, .to_p_m = pivot});
    put_text(object.name, moves_.back().name);
  }
  std::sort(by_name_.begin(), by_name_.end());
}

std::string_view ObjectMover::name_of(std::int32_t object) const noexcept {
  return static_cast<std::size_t>(object) < names_.size() ? std::string_view(names_[static_cast<std::size_t>(object)]) : "";
}

ObjectMover::Found ObjectMover::find(const MoveRequest& request) const noexcept {
  const std::string_view name = text_of(request.object);
  if (name.empty()) {
    const bool is_there = static_cast<std::size_t>(request.number) < names_.size();
    return is_there ? Found{request.number, 1} : Found{};
  }
  const auto first = std::lower_bound(by_name_.begin(), by_name_.end(), name, is_before);
  Found found;
  for (auto one = first; one != by_name_.end() && one->first == name; ++one) ++found.count;
  if (found.count == 1) found.object = first->second;
  return found;
}

void ObjectMover::request(const MoveRequest& request) noexcept {
  const Waiting waiting{request, find(request).object};
  const auto end = waiting_.begin() + static_cast<std::ptrdiff_t>(waiting_count_);
  const auto earlier = std::find_if(waiting_.begin(), end, [&](const Waiting& one) { return one.object == waiting.object; });
  if (earlier != end) {
    if (earlier->request.request == request.request) return;
    // A repeated request that was already carried out must not replace a newer one.
    if (find_reply(request.request) == nullptr) {
      reject_overtaken(*earlier);
      *earlier = waiting;
    }
    return;
  }
  if (waiting_count_ == kMaxWaiting) {
    ++overflows_;
    return;
  }
  waiting_[waiting_count_++] = waiting;
}

// Whether enough time has passed since the start of the last move, if that move has not begun (kMaxFutureMoves).
bool ObjectMover::may_begin(const Waiting& waiting, std::int64_t start_ns) const noexcept {
  const auto newest_move = std::find_if(moves_.begin(), moves_.end(), [&](const ObjectMove& one) { return one.object == waiting.object; });
  return newest_move == moves_.end() || newest_move->serial == 0 || start_ns < newest_move->start_ns ||
         start_ns - newest_move->start_ns >= lead_ns_ / kMaxFutureMoves;
}

ObjectMover::Outcome ObjectMover::carry_out(HapticsStep& step) noexcept {
  const auto end = waiting_.begin() + static_cast<std::ptrdiff_t>(waiting_count_);
  const std::int64_t start_ns = step.scene_time_ns() + lead_ns_;
  const auto next = std::find_if(waiting_.begin(), end, [&](const Waiting& one) { return may_begin(one, start_ns); });
  if (next == end) return {};
  const Waiting waiting = *next;
  std::move(next + 1, end, next);
  --waiting_count_;
  Outcome outcome;
  if (const MoveReply* earlier_reply = find_reply(waiting.request.request)) {
    outcome.reply = *earlier_reply;
    return outcome;
  }
  outcome.reply.request = waiting.request.request;
  if (waiting.object < 0 || objects_[static_cast<std::size_t>(waiting.object)] == nullptr) {
    reject_unknown(waiting.request, outcome.reply.rejection);
  } else {
    move(step, waiting, outcome);
  }
  add_reply(outcome.reply);
  return outcome;
}

void ObjectMover::move(HapticsStep& step, const Waiting& waiting, Outcome& outcome) noexcept {
  const CommandedMotion* motion = step.touch().find_commanded(waiting.object);
  const CommandedObject& object = *objects_[static_cast<std::size_t>(waiting.object)];
  if (motion == nullptr) return format_into(outcome.reply.rejection, "the method in use does not move objects");
  const std::int64_t start_ns = step.scene_time_ns() + lead_ns_;
  const MoveRequest& requested = waiting.request;
  const Keyframe from = motion->keyframe_at(1e-9 * static_cast<double>(start_ns));
  const Keyframe to = object.place(requested.p_m, requested.q, from);
  const double seconds = compute_move_time_s(from, to, requested.over_s.value_or(0.0), object.radius_m(), kMaxSurfaceSpeed);
  if (!(seconds <= MoveRequest::kMaxSeconds)) {
    return format_into(outcome.reply.rejection, "'{}' would need {:.3g} s at {:g} m/s: it may take a day at most", name_of(waiting.object),
                       seconds, kMaxSurfaceSpeed);
  }
  const auto newest_move = std::find_if(moves_.begin(), moves_.end(), [&](const ObjectMove& one) { return one.object == waiting.object; });
  newest_move->serial = static_cast<std::uint32_t>(step.counts().moves_taken) + 1;
  newest_move->start_ns = start_ns;
  newest_move->end_ns = start_ns + static_cast<std::int64_t>(std::ceil(1e9 * seconds));
  newest_move->from_p_m = from.p_S;
  newest_move->from_q = from.turn;
  newest_move->to_p_m = to.p_S;
  newest_move->to_q = to.turn;
  step.command(waiting.object, to_command(*newest_move));
  outcome.reply.object = waiting.object;
  outcome.reply.over_s = seconds;
  outcome.reply.serial = newest_move->serial;
  outcome.move = *newest_move;
}

void ObjectMover::reject_unknown(const MoveRequest& request, HapticsSetup::Text& rejection) const noexcept {
  const std::string_view name = text_of(request.object);
  const Found found = find(request);
  if (found.object >= 0) {
    format_into(rejection, "programs may not move '{}': give it moved_by = \"program\" in the scene file", name_of(found.object));
  } else if (found.count > 1) {
    format_into(rejection, "{} objects are named '{}': give the number of one, from 0", found.count, name);
  } else if (name.empty()) {
    format_into(rejection, "there is no object {}: the scene has {}, numbered from 0", request.number, names_.size());
  } else if (moves_.empty()) {
    format_into(rejection, "there is no object '{}', and none that programs may move (moved_by = \"program\" in the scene file)", name);
  } else {
    format_into(rejection, "there is no object '{}'; programs may move '{}'{}", name, name_of(moves_.front().object),
                moves_.size() > 1 ? " and others" : "");
  }
}

const MoveReply* ObjectMover::find_reply(std::uint32_t request) const noexcept {
  const auto earlier_reply = std::find_if(replies_.begin(), replies_.end(), [&](const MoveReply& one) { return one.request == request; });
  return earlier_reply != replies_.end() ? &*earlier_reply : nullptr;
}

void ObjectMover::add_reply(const MoveReply& reply) noexcept {
  replies_[next_reply_] = reply;
  next_reply_ = (next_reply_ + 1) % kMaxReplies;
}

void ObjectMover::reject_overtaken(const Waiting& waiting) noexcept {
  MoveReply reply{.request = waiting.request.request};
  if (waiting.object >= 0) {
    reply.object = waiting.object;
    format_into(reply.rejection, "a newer request for '{}' replaced this one", name_of(waiting.object));
  } else {
    reject_unknown(waiting.request, reply.rejection);
  }
  add_reply(reply);
}

}  // namespace hapton
