#include "io_node/patch_link.h"

#include <algorithm>
#include <utility>

#include "core/math/rigid_pose.h"

namespace hapton {
namespace {

constexpr std::int64_t kRoundTripCheckNs = 100 * kNanosecondsPerMillisecond;  // between two readings of the round trip

// The scene time at a sample, as the device side computes it.
std::int64_t scene_time_at(const ForceCommand& last, std::int64_t sample_ns) noexcept {
  return std::max<std::int64_t>(last.scene_time_ns + (sample_ns - last.echo_sample_time_ns), 0);
}

}  // namespace

// The number of the present request for parts: another one in each session and after parts were dropped, and never 0.
std::uint32_t PatchLink::request() const noexcept { return (static_cast<std::uint32_t>(peers_.session()) + 2 * orders_.clear_count) | 1U; }

void PatchLink::accept(const Message& part) noexcept {
  if (const auto* begin = std::get_if<PatchBegin>(&part); begin != nullptr && !note_begin(*begin)) return;
  // The part comes from the previous haptics node, or was not requested.
  if (must_clear_ || state_ == State::remote) return;
  thread_.push(part);
}

// False: the parts that begin are not wanted, or were sent for an earlier request.
bool PatchLink::note_begin(const PatchBegin& begin) noexcept {
  is_reply_due_ = is_reply_due_ || state_ == State::remote;
  if (must_clear_ || state_ == State::remote || (begin.request != 0 && begin.request != request())) return false;
  if (begin_epoch_ != 0 && static_cast<std::int32_t>(begin.epoch - begin_epoch_) <= 0) return true;
  begin_epoch_ = begin.epoch;
  min_method_serial_ = begin.method_serial;
  // Published before the patch thread gets this message, because the device side takes its patches at once.
  if (needs_start() && std::exchange(orders_.may_begin, false)) local_patch_.publish(orders_);
  return true;
}

// Serials wrap around at 2^32, so the sign of their difference tells which is newer.
bool PatchLink::is_new_enough(std::uint32_t method_serial) const noexcept {
  return static_cast<std::int32_t>(method_serial - min_method_serial_) >= 0;
}

void PatchLink::note_start(std::uint32_t method_serial) noexcept {
  ++orders_.start_serial;
  start_method_serial_ = method_serial;
  has_start_ = true;
}

void PatchLink::accept(const ObjectMove& move) noexcept {
  const std::uint32_t newest = moves_.newest();
  if (moves_.take(move)) local_patch_.publish(moves_);
  has_news_ = has_news_ || moves_.newest() != newest;
}

void PatchLink::accept_shape(const Message& shape, Arrival arrival) noexcept {
  if (!must_clear_ && state_ != State::remote) thread_.push_shape(shape, arrival);
}

// The parts received so far are not used any more.
void PatchLink::drop_parts() noexcept {
  orders_.clear_count += std::exchange(must_clear_, true) ? 0 : 1;
  begin_epoch_ = min_method_serial_ = 0;
}

void PatchLink::on_haptics_joined() noexcept {
  drop_parts();
  may_begin_ = has_start_ = false;
  moves_.clear();
  local_patch_.publish(moves_);
}

void PatchLink::update(ForceExchange& forces, const std::optional<ViewTransform>& view, std::int64_t now_ns) noexcept {
  if (must_clear_) must_clear_ = !thread_.clear();
  choose_source(forces, now_ns);
  if (state_ == State::remote) {
    if (is_reply_due_ && now_ns - last_status_ns_ >= kMinStatusNs) send_status(round_trip_s_, now_ns);
    return;
  }
  follow_source(forces);
  may_begin_ = may_begin_ || forces.has_resumed();
  if (!was_local_) note_probe(forces, view ? view->revision : 0, now_ns);
  orders_.may_begin = may_begin_ && !needs_start();
  orders_.X_WS = view ? find_rigid_pose(view->X_WS).value_or(Pose::Identity()) : Pose::Identity();
  orders_.remote_force_ns = forces.history().last_reply().echo_sample_time_ns;
  orders_.remote_force_scene_ns = forces.history().last_reply().scene_time_ns;
  orders_.until_ns = peers_.has_haptics() ? peers_.peer(HubPeers::kHapticsSlot).last_received_ns + kMaxSilenceNs : 0;
  local_patch_.publish(orders_);
  if (const auto missing = thread_.take_shape_request()) peers_.send_to_role(NodeRole::haptics, *missing);
  has_news_ = thread_.take_status() || has_news_;
  if (now_ns - last_status_ns_ >= (has_news_ ? kMinStatusNs : kStatusNs)) send_status(round_trip_s_, now_ns);
}

void PatchLink::finish() noexcept {
  orders_.is_wanted = false;
  local_patch_.publish(orders_);
}

void PatchLink::choose_source(ForceExchange& forces, std::int64_t now_ns) noexcept {
  if (now_ns >= next_round_trip_check_ns_) {
    next_round_trip_check_ns_ = now_ns + kRoundTripCheckNs;
    round_trip_s_ = state_ == State::remote ? forces.find_lasting_round_trip_s() : forces.find_round_trip_s();
  }
  const bool is_wanted = peers_.has_haptics() && chooser_.choose_patch(round_trip_s_, now_ns);
  if (state_ == State::remote && is_wanted) {
    // Since patches were last wanted, the haptics node may have got another scene or method, which this side does not know yet.
    drop_parts();
    state_ = State::patch;
    orders_.is_wanted = true;
    was_local_ = false;
    last_status_ns_ = probe_noted_ns_ = 0;
    may_begin_ = start_at_rest(forces);
  }
  if (state_ == State::patch && !is_wanted) {
    state_ = State::leaving;
    forces.request_resume();
  }
  if (state_ == State::leaving && (forces.has_resumed() || !forces.is_local())) {
    state_ = State::remote;
    // Samples are few while the force is local, so most round trips that are known are from before the network became fast.
    forces.settle_round_trip();
    round_trip_s_ = forces.find_round_trip_s();
    orders_.is_wanted = false;
    local_patch_.publish(orders_);
    send_status(round_trip_s_, now_ns);
  }
}

// A haptics node that has just joined gets the place of contact, and so does the device side: a patch that is ready before the node's first
// reply must not treat a hand inside a body as one in free space. False: no contact is known here.
bool PatchLink::start_at_rest(const ForceExchange& forces) noexcept {
  const ProbeHistory::Pose& newest = forces.history().newest();
  const std::optional<Vec3> p_WP = forces.history().find_resume_point(newest.p_WD);
  if (!p_WP || !forces.history().last_reply().contact) return false;
  ++orders_.start_serial;  // not note_start(): the previous haptics node counted its methods differently from this one
  orders_.start_ns = newest.time_ns;
  orders_.start_scene_ns = scene_time_at(forces.history().last_reply(), newest.time_ns);
  orders_.p_WP = *p_WP;
  orders_.outward_W = (*p_WP - newest.p_WD).normalized();
  return true;
}

// When patches no longer give the force, the haptics node goes on from their probe (request_resume): note its next place of the probe soon.
void PatchLink::follow_source(const ForceExchange& forces) noexcept {
  const bool was_local = std::exchange(was_local_, forces.is_local());
  if (was_local && !was_local_ && state_ == State::patch) probe_noted_ns_ = 0;
}

// Notes where patches may start: the place of the probe, in the scene as it is turned now. Only replies of the present haptics node count:
// from an older place, a hand that has moved elsewhere meanwhile would touch what lies between.
void PatchLink::note_probe(const ForceExchange& forces, std::uint32_t view_revision, std::int64_t now_ns) noexcept {
  if (!forces.has_resumed()) return;
  const ForceCommand& last = forces.history().last_reply();
  const bool is_awaited = needs_start() && is_new_enough(last.method_serial);
  if ((now_ns - probe_noted_ns_ < kProbeNs && !is_awaited) || last.view_revision != view_revision ||
      last.echo_sample_time_ns <= orders_.start_ns)
    return;
  const std::optional<Vec3> p_WP = forces.history().find_probe();
  if (!p_WP) return;
  probe_noted_ns_ = now_ns;
  const double depth = last.held_offset().norm();
  note_start(last.method_serial);
  orders_.start_ns = last.echo_sample_time_ns;
  orders_.start_scene_ns = last.scene_time_ns;
  orders_.p_WP = *p_WP;
  orders_.outward_W = last.contact && depth > 0.0 ? Vec3(last.held_offset() / depth) : Vec3(Vec3::Zero());
}

void PatchLink::send_status(double round_trip_s, std::int64_t now_ns) noexcept {
  PatchStatus status = must_clear_ ? PatchStatus() : thread_.status();
  status.is_wanted = state_ != State::remote;
  status.newest_move = moves_.newest();
  status.moves_received = moves_.received();
  status.request = request();
  status.knows_effects = true;
  status.round_trip_s = static_cast<float>(std::max(round_trip_s, 0.0));
  last_status_ns_ = now_ns;
  has_news_ = is_reply_due_ = false;
  peers_.send_to_role(NodeRole::haptics, status);
}

}  // namespace hapton
