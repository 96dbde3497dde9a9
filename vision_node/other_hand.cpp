#include "vision_node/other_hand.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/base/period_ns.h"
#include "runtime/log.h"

namespace hapton {
namespace {

std::uint32_t to_message_ns(std::int64_t ns, std::int64_t least) {
  return static_cast<std::uint32_t>(std::clamp<std::int64_t>(ns, least, std::numeric_limits<std::uint32_t>::max()));
}

}  // namespace

void OtherHand::update(const Pose& X_WS, std::int64_t now_ns) {
  receive_states();
  const bool is_joined = hub_.state() == JoinState::joined;
  if (is_joined && (!was_joined_ || hub_.counts().joins != joins_)) {
    log_info("joined the other hand's hub, servo rate {:.0f} Hz", hub_.servo_rate_hz());
    sender_.rejoin();
  } else if (!is_joined && was_joined_) {
    if (hub_.has_hub_left()) {
      log_info("the other hand's hub has ended its session; waiting for the next one");
    } else {
      log_warning("the other hand's hub stopped replying; retrying");
    }
  }
  was_joined_ = is_joined;
  joins_ = hub_.counts().joins;
  sender_.set(X_WS);
  if (!is_joined) return;
  if (const auto view = sender_.take_due(now_ns)) hub_.send(*view);
}

void OtherHand::receive_states() {
  Datagram received;
  while (hub_.receive(received, 0)) {
    if (const auto* rejected = std::get_if<ViewRejected>(&received.message)) sender_.reject(rejected->revision);
    if (const auto* view = std::get_if<ViewTransform>(&received.message)) sender_.count_from(view->revision);
    const auto* state = std::get_if<ProbeState>(&received.message);
    if (state == nullptr || hub_.last_arrival() != Arrival::newest) continue;
    state_ = *state;
    received_ns_ = hub_.receive_time_ns();
    has_new_state_ = true;
    sender_.confirm(state->view_revision);
  }
}

bool OtherHand::wants_picture(const ProbeSizes& sizes, const StereoScreen& screen, PictureSize size) {
  if (!std::exchange(has_new_state_, false)) return false;
  if (watch_.differs(*shown(), sizes, screen, size)) return true;
  (void)acks_.note(received_ns_, received_ns_);
  hub_.send(FrameAck{.echo_sample = state_->sample, .echo_sample_time_ns = state_->sample_time_ns, .unchanged = true});
  return false;
}

std::optional<ProbeShown> OtherHand::shown() const {
  if (!state_) return std::nullopt;
  return make_shown_probe(*state_, stylus_lean_);
}

void OtherHand::end_frame(std::int64_t start_ns, std::int64_t end_ns, double frame_rate_hz, const ProbeSizes& sizes,
                          const StereoScreen& screen, PictureSize size) {
  if (!state_) return;
  has_new_state_ = false;
  watch_.note_drawn(*shown(), sizes, screen, size);
  const StateAcks::Kind kind = acks_.note(received_ns_, end_ns);
  if (kind == StateAcks::Kind::none) return;
  const bool is_first = kind == StateAcks::Kind::first;
  FrameAck ack{.echo_sample = state_->sample,
               .echo_sample_time_ns = state_->sample_time_ns,
               .frame_rate_hz = static_cast<float>(frame_rate_hz),
               .held_ns = is_first ? to_message_ns(end_ns - received_ns_, 1) : 0,
               .unchanged = !is_first};
  if (max_rate_hz_ > 0.0) ack.rest_ns = to_message_ns(start_ns + period_ns(max_rate_hz_) - end_ns, 0);
  hub_.send(ack);
}

}  // namespace hapton
