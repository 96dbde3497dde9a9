#include "io_node/patch_link.h"

#include <algorithm>

#include "core/math/rigid_pose.h"

namespace hapton {
namespace {

constexpr std::int64_t kLookNs = 100 * kNanosecondsPerMillisecond;

}  // namespace

void PatchLink::accept(const Message& part) noexcept {
  // Of the node before, or not asked for.
  if (must_clear_ || state_ == State::remote) return;
  builder_.push(part);
}

void PatchLink::look_after(ForceExchange& forces, const std::optional<ViewTransform>& view, std::int64_t now_ns) noexcept {
  if (must_clear_) must_clear_ = !builder_.clear();
  choose(forces, now_ns);
  if (state_ == State::remote) return;
  orders_.X_WS = view ? find_rigid_pose(view->X_WS).value_or(Pose::Identity()) : Pose::Identity();
  orders_.until_ns = peers_.has_haptics() ? peers_.peer(HubPeers::kHapticsSlot).last_received_ns + kAloneNs : 0;
  local_.publish(orders_);
  has_news_ = builder_.take_status() || has_news_;
  if (now_ns - status_ns_ >= (has_news_ ? kSoonNs : kStatusNs)) send_status(round_trip_s_, now_ns);
}

void PatchLink::choose(ForceExchange& forces, std::int64_t now_ns) noexcept {
  if (now_ns >= next_look_ns_) {
    next_look_ns_ = now_ns + kLookNs;
    round_trip_s_ = forces.find_round_trip_s();
  }
  const bool is_wanted = peers_.has_haptics() && chooser_.wants_patch(round_trip_s_, now_ns);
  if (state_ == State::remote && is_wanted) start(forces);
  if (state_ == State::patch && !is_wanted) {
    state_ = State::leaving;
    forces.request_resume();
  }
  if (state_ == State::leaving && (forces.has_resumed() || !forces.is_local())) {
    state_ = State::remote;
    orders_.is_wanted = false;
    local_.publish(orders_);
    send_status(round_trip_s_, now_ns);
  }
}

// From where the haptics node has the probe.
void PatchLink::start(const ForceExchange& forces) noexcept {
  state_ = State::patch;
  orders_.is_wanted = true;
  status_ns_ = 0;
  const ForceCommand& last = forces.history().last_answer();
  const std::optional<Vec3> p_WP = forces.history().find_probe();
  if (!p_WP) return;
  const double depth = last.visual_offset_m.norm();
  ++orders_.start;
  orders_.p_WP = *p_WP;
  orders_.outward_W = last.contact && depth > 0.0 ? Vec3(last.visual_offset_m / depth) : Vec3(Vec3::Zero());
}

void PatchLink::send_status(double round_trip_s, std::int64_t now_ns) noexcept {
  PatchStatus status = builder_.status();
  status.is_wanted = state_ != State::remote;
  status.round_trip_s = static_cast<float>(std::max(round_trip_s, 0.0));
  status_ns_ = now_ns;
  has_news_ = false;
  peers_.send_to_role(NodeRole::haptics, status);
}

}  // namespace hapton
