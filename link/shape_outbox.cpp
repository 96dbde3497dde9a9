#include "link/shape_outbox.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "link/codec.h"
#include "link/object_choice.h"
#include "link/random_id.h"
#include "link/shape_parts.h"
#include "link/wire_fields.h"

namespace hapton {
namespace {

Result<void> check_shape(std::span<const ShapePart::Displacement> displacements_m, double over_s) {
  if (displacements_m.empty() || displacements_m.size() > ShapePart::kMaxVertices) {
    return fail("a shape has 1 to {} vertices, not {}", ShapePart::kMaxVertices, displacements_m.size());
  }
  if (!(over_s >= 0.0 && over_s <= ShapeRequest::kMaxSeconds)) {
    return fail("the motion to a shape takes 0 to {:g} s, not {:g} s", ShapeRequest::kMaxSeconds, over_s);
  }
  for (std::size_t v = 0; v < displacements_m.size(); ++v) {
    for (const float x : displacements_m[v]) {
      if (!(std::abs(x) <= static_cast<float>(kMaxWireMagnitude))) {
        return fail("the displacement of vertex {} is not finite, or above {:g} m", v, kMaxWireMagnitude);
      }
    }
  }
  return {};
}

bool is_same_object(const ShapeRequest& a, const ShapeRequest& b) { return a.object == b.object && a.number == b.number; }

}  // namespace

ShapeOutbox::ShapeOutbox() : stream_(static_cast<std::uint32_t>(make_random_id()) | 1U) {}

Result<std::uint32_t> ShapeOutbox::give(std::string_view object, std::span<const ShapePart::Displacement> displacements_m, double over_s,
                                        bool is_needed) {
  Shape shape{.head = {.stream = stream_, .over_s = over_s},
              .displacements_m = {displacements_m.begin(), displacements_m.end()},
              .is_needed = is_needed};
  if (const auto chosen = choose_object(object, shape.head.object, shape.head.number); !chosen) return tl::unexpected(chosen.error());
  if (const auto checked = check_shape(displacements_m, over_s); !checked) return tl::unexpected(checked.error());
  const std::scoped_lock lock(mutex_);
  shape.head.shape = ++newest_;
  // A shape that is partly sent is finished first, so that some shapes arrive whole even if the program gives shapes too fast.
  std::erase_if(shapes_, [&](const Shape& one) {
    return is_same_object(one.head, shape.head) && (one.next == 0 || one.next >= one.displacements_m.size());
  });
  for (Shape& one : shapes_) {
    if (is_same_object(one.head, shape.head)) one.is_needed = false;
  }
  shapes_.push_back(std::move(shape));
  return newest_;
}

void ShapeOutbox::send(HubClient& client, std::int64_t now_ns) {
  const std::scoped_lock lock(mutex_);
  if (shapes_.empty() || now_ns < next_send_ns_) return;
  next_send_ns_ = now_ns + kEveryNs;
  std::size_t parts_left = kPartsAtOnce;
  for (Shape& shape : shapes_) {
    if (shape.is_needed && shape.next >= shape.displacements_m.size() && now_ns >= shape.repeat_ns) shape.next = 0;
    while (parts_left > 0 && shape.next < shape.displacements_m.size()) {
      shape.head.part = make_shape_part(shape.displacements_m, shape.next);
      client.send(shape.head);
      shape.next += ShapePart::kVerticesPerPart;
      shape.repeat_ns = now_ns + kRepeatNs;
      --parts_left;
    }
    if (parts_left == 0) break;
  }
  std::erase_if(shapes_, [&](const Shape& one) { return is_done(one); });
}

void ShapeOutbox::take(const Message& message) {
  const auto* reply = std::get_if<ShapeReply>(&message);
  if (reply == nullptr || reply->stream != stream_) return;
  const std::scoped_lock lock(mutex_);
  for (Shape& shape : shapes_) {
    if (shape.head.shape == reply->shape) shape.is_needed = false;
  }
  std::erase_if(shapes_, [&](const Shape& one) { return is_done(one); });
  std::erase_if(replies_, [&](const ShapeReply& one) { return one.shape == reply->shape; });
  if (replies_.size() == kMaxReplies) replies_.erase(replies_.begin());
  replies_.push_back(*reply);
  reply_arrived_.notify_all();
}

bool ShapeOutbox::is_empty() const {
  const std::scoped_lock lock(mutex_);
  return shapes_.empty();
}

const ShapeReply* ShapeOutbox::reply_to(std::uint32_t shape) const {
  const auto found = std::find_if(replies_.begin(), replies_.end(), [&](const ShapeReply& one) { return one.shape == shape; });
  return found != replies_.end() ? &*found : nullptr;
}

std::optional<ShapeReply> ShapeOutbox::find_reply(std::uint32_t shape) const {
  const std::scoped_lock lock(mutex_);
  const ShapeReply* reply = reply_to(shape);
  return reply != nullptr ? std::optional(*reply) : std::nullopt;
}

Result<double> ShapeOutbox::give_up(std::uint32_t shape, double seconds) {
  const std::scoped_lock lock(mutex_);
  return end_wait(shape, seconds);
}

Result<double> ShapeOutbox::end_wait(std::uint32_t shape, double seconds) {
  if (const ShapeReply* reply = reply_to(shape)) return read_reply(*reply);
  std::erase_if(shapes_, [&](const Shape& one) { return one.head.shape == shape; });
  return fail("no reply to the shape within {:g} s; start haptics_node, or another shape took its place", seconds);
}

Result<double> ShapeOutbox::wait_for(std::uint32_t shape, double seconds) {
  std::unique_lock lock(mutex_);
  reply_arrived_.wait_for(lock, std::chrono::duration<double>(seconds), [&] { return reply_to(shape) != nullptr; });
  return end_wait(shape, seconds);
}

Result<double> read_reply(const ShapeReply& reply) {
  if (reply.rejection[0] != '\0') return fail("the haptics node rejected the shape: {}", reply.rejection.data());
  return reply.over_s;
}

Result<double> deform_object(HubClient& client, const Clock& clock, ShapeOutbox& outbox, std::string_view object,
                             std::span<const ShapePart::Displacement> displacements_m, double over_s, double seconds) {
  const auto shape = outbox.give(object, displacements_m, over_s, true);
  if (!shape) return tl::unexpected(shape.error());
  const std::int64_t end_ns = clock.now_ns() + static_cast<std::int64_t>(1e9 * seconds);
  Datagram datagram;
  for (std::int64_t now_ns = clock.now_ns(); now_ns < end_ns; now_ns = clock.now_ns()) {
    outbox.send(client, now_ns);
    while (client.receive(datagram, std::min(end_ns, now_ns + ShapeOutbox::kEveryNs))) outbox.take(datagram.message);
    if (const auto reply = outbox.find_reply(*shape)) return read_reply(*reply);
  }
  return outbox.give_up(*shape, seconds);
}

}  // namespace hapton
