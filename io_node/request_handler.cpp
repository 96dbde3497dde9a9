#include "io_node/request_handler.h"

#include <algorithm>
#include <optional>

#include "link/key_role.h"
#include "safety/reset_permission.h"

namespace hapton {

void RequestHandler::accept(const Settings& settings, const PeerEvent& event) noexcept {
  if (settings.servo_rate_hz != 0.0) set_rate(settings.servo_rate_hz, event.role);
  if (settings.method[0] != '\0') request_method(settings, event.role);
  if (settings.reset_faults && event.role == NodeRole::tool) reset_faults(peers_.peer(event.peer));
  if (settings.report_now) is_report_requested_.store(true, std::memory_order_release);
}

void RequestHandler::set_rate(double rate_hz, NodeRole role) noexcept {
  if (!(rate_hz >= kMinServoRateHz && rate_hz <= kMaxServoRateHz)) {
    ++stats_.bad_settings;
    return;
  }
  rate_hz_ = rate_hz;
  loop_.set_rate_hz(rate_hz);
  peers_.set_servo_rate_hz(rate_hz);
  events_.push({ServoEvent::Kind::rate_changed, role, {}, rate_hz, {}, {}});
}

void RequestHandler::request_method(const Settings& settings, NodeRole role) noexcept {
  peers_.send_to_role(NodeRole::haptics, Settings{0.0, settings.method, false, false, settings.method_request});
  events_.push({ServoEvent::Kind::method_requested, role, {}, 0.0, settings.method, {}});
}

void RequestHandler::accept(const MaterialRequest& request, const PeerEvent& event) noexcept {
  peers_.send_to_role(NodeRole::haptics, request);
  events_.push({ServoEvent::Kind::material_requested, event.role, {}, 0.0, {}, {}});
}

void RequestHandler::accept(const MoveRequest& request, const PeerEvent& event) noexcept {
  if (!move_buckets_[event.peer].take(event.receive_time_ns)) {
    ++stats_.moves_rejected;
    return;
  }
  awaited_moves_[next_awaited_] = {request.request, event.peer};
  next_awaited_ = (next_awaited_ + 1) % kMovesAwaited;
  peers_.send_to_role(NodeRole::haptics, request);
}

void RequestHandler::accept(const MoveReply& reply) noexcept {
  const auto awaited = std::find_if(awaited_moves_.begin(), awaited_moves_.end(),
                                    [&](const AwaitedMove& one) { return one.request == reply.request && one.peer != kNobody; });
  if (awaited != awaited_moves_.end()) peers_.send_to(awaited->peer, reply);
}

void RequestHandler::accept(const ShapeRequest& part, const PeerEvent& event) noexcept {
  if (!shape_buckets_[event.peer].take(event.receive_time_ns) || !all_shapes_bucket_.take(event.receive_time_ns)) {
    ++stats_.shape_parts_rejected;
    return;
  }
  shape_streams_[event.peer] = part.stream;
  peers_.send_to_role(NodeRole::haptics, part);
}

void RequestHandler::accept(const ShapeReply& reply) noexcept {
  const auto sender = std::find(shape_streams_.begin(), shape_streams_.end(), reply.stream);
  if (sender != shape_streams_.end()) peers_.send_to(static_cast<std::size_t>(sender - shape_streams_.begin()), reply);
}

void RequestHandler::reset_faults(const Peer& sender) noexcept {
  const DeviceSide& side = loop_.latest();
  if (side.governor.fault == SafetyFault::none) return;
  const bool is_from_this_host = is_loopback(sender.address);
  switch (check_reset(sender.key_role, is_from_this_host, side.is_switch_held)) {
    case ResetDecision::no_right:
      return note_denied(ServoEvent::Kind::reset_without_right, sender);
    case ResetDecision::no_person:
      return note_denied(ServoEvent::Kind::reset_without_person, sender);
    case ResetDecision::granted:
      return loop_.reset_faults(is_from_this_host ? ResetPresence::known : ResetPresence::while_held);
  }
}

// Every denied reset is counted; the log gets at most one line a second.
void RequestHandler::note_denied(ServoEvent::Kind why, const Peer& sender) noexcept {
  ++resets_denied_;
  if (clock_.now_ns() < next_denial_notice_ns_) return;
  next_denial_notice_ns_ = clock_.now_ns() + kNanosecondsPerSecond;
  events_.push({why, sender.role, sender.address, 0.0, {}, {}});
}

void RequestHandler::accept(const HandTarget& target, std::size_t peer) noexcept {
  if (!target.active && hand_controller_ != peer) return;
  hand_controller_ = target.active ? peer : kNobody;
  loop_.set_hand_target(target.active ? std::optional(target.p_WH) : std::nullopt, target.buttons, target.turn_rad);
}

void RequestHandler::on_peer_gone(std::size_t peer) noexcept {
  if (peer == hand_controller_) accept(HandTarget{}, peer);
  for (AwaitedMove& one : awaited_moves_) {
    if (one.peer == peer) one.peer = kNobody;
  }
  move_buckets_[peer] = TokenBucket(kMovesPerSecond, kMovesAtOnce);
  shape_buckets_[peer] = TokenBucket(kShapePartsPerSecond, kShapePartsAtOnce);
  shape_streams_[peer] = 0;
}

}  // namespace hapton
