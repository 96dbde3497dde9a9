#include "io_node/force_exchange.h"

#include <algorithm>
#include <utility>

namespace hapton {

// False after a silence of haptics_timeout_ns(): then the node loses its slot to the next haptics node that joins.
bool ForceExchange::is_haptics_alive(std::int64_t now_ns) const noexcept {
  return peers_.has_haptics() && now_ns - peers_.peer(HubPeers::kHapticsSlot).last_received_ns < peers_.haptics_timeout_ns();
}

// True: the sample is not sent, as the haptics node needs few of them. While the node has to go on from the probe's position it gets all.
bool ForceExchange::is_thinned(const DeviceCycle& cycle) const noexcept {
  return cycle.local && !history_.is_haptics_new() && cycle.sample.buttons == sent_buttons_ &&
         cycle.sample.time_ns - sent_ns_ < static_cast<std::int64_t>(1e9 / kThinnedHz);
}

void ForceExchange::add_cycle(const DeviceCycle& cycle, bool is_newest) noexcept {
  const std::int64_t time_ns = cycle.sample.time_ns;
  note_source(cycle.local.has_value());
  sends_newest_ = is_newest && !is_thinned(cycle);
  if (sends_newest_) {
    sent_ns_ = time_ns;
    sent_buttons_ = cycle.sample.buttons;
    const bool is_warm = time_ns - peers_.peer(HubPeers::kHapticsSlot).joined_ns >= ResponseTracker::kWarmUpNs;
    responses_.take(cycle.number, time_ns, is_haptics_alive(time_ns) && is_warm);
  } else {
    responses_.withhold(cycle.number, time_ns);
  }
  history_.note_sample(cycle.number, cycle.sample);
}

// Called before the sample is counted, so that a request to go on from the probe's position is sent with this sample.
void ForceExchange::note_source(bool is_local) noexcept {
  const bool was_local = std::exchange(is_local_, is_local);
  peers_.set_haptics_timeout_ns(is_local ? kThinnedTimeoutNs : HubPeers::kHapticsTimeoutNs);
  if (was_local && !is_local && !is_resume_requested_) request_resume();
  if (!was_local && is_local) is_resume_requested_ = false;
}

void ForceExchange::send(const DeviceCycle& cycle) noexcept {
  if (!sends_newest_) return;
  const DeviceSample& sample = cycle.sample;
  DeviceState state{cycle.number, sample.time_ns, sample.p_WD, sample.q_WT, sample.buttons};
  const std::optional<Vec3> p_WP = history_.find_resume_point(sample.p_WD);
  state.is_resumed = p_WP.has_value();
  if (p_WP) state.p_WP = *p_WP;
  if (cycle.local) state.scene_time_ns = cycle.local->scene_time_ns;
  const std::size_t reached = peers_.send_to_role(NodeRole::haptics, state);
  stats_.states_sent += reached;
  if (hops_ != nullptr && reached > 0) hops_->on_state_sent(cycle.number, sample.time_ns);
}

void ForceExchange::accept(const Header& header, const ForceCommand& command) noexcept {
  const ResponseTracker::Verdict verdict = responses_.reply(command);
  if (verdict == ResponseTracker::Verdict::duplicate || verdict == ResponseTracker::Verdict::unknown) return;
  const std::int64_t now_ns = clock_.now_ns();
  note_trip(now_ns - command.echo_sample_time_ns, now_ns);
  if (is_local_) {
    note_round_trip(header, command, now_ns);
    history_.note_resumed(command.echo_sample);
  } else if (verdict == ResponseTracker::Verdict::reordered || history_.is_before_resume(command.echo_sample)) {
    note_round_trip(header, command, now_ns);
  } else {
    note_written();  // for the previous force
    const std::uint64_t number = loop_.post({{.force_n = command.force_n, .torque_nm = command.torque_nm}, command.echo_sample_time_ns});
    posted_ = Posted{number, header, command};
    note_written();
    history_.note_reply(command);
  }
  ++stats_.forces;
  stats_.contact_samples += command.contact ? 1 : 0;
}

void ForceExchange::note_written() noexcept {
  const DeviceSide& side = loop_.latest();
  if (!posted_ || side.command_number != posted_->number) return;
  // The command filter rejects a force that is older than the command timeout: then what was written is not this force.
  const std::int64_t sample_ns = posted_->command.echo_sample_time_ns;
  if (side.ready_ns - sample_ns < kCommandTimeoutNs) stats_.force_age.record(side.written_ns - sample_ns);
  if (hops_ != nullptr) hops_->on_force_written(side.ready_ns, side.written_ns);
  note_round_trip(posted_->header, posted_->command, side.ready_ns);
  posted_.reset();
}

void ForceExchange::note_round_trip(const Header& header, const ForceCommand& command, std::int64_t ready_ns) noexcept {
  const std::int64_t round_trip_ns = ready_ns - command.echo_sample_time_ns;
  if (hops_ != nullptr) hops_->on_force(header, command, ready_ns);
  stats_.round_trip.record(round_trip_ns);
  stats_.haptics_compute.record(command.compute_ns);
  stats_.wire.record(round_trip_ns - static_cast<std::int64_t>(command.compute_ns));
}

// One round trip in kTripEveryNs is enough to choose where forces are computed; the others are not stored.
void ForceExchange::note_trip(std::int64_t round_trip_ns, std::int64_t now_ns) noexcept {
  if (now_ns - last_trip_ns_ < kTripEveryNs) return;
  last_trip_ns_ = now_ns;
  trips_s_[trip_count_++ % kTrips] = static_cast<float>(1e-9 * static_cast<double>(round_trip_ns));
}

double ForceExchange::find_median_s(std::size_t max_trips) const noexcept {
  if (trip_count_ < kNewestTrips / 2) return -1.0;
  std::array<float, kTrips> sorted = {};
  const std::size_t count = std::min(trip_count_, max_trips);
  for (std::size_t n = 0; n < count; ++n) sorted[n] = trips_s_[(trip_count_ - 1 - n) % kTrips];
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(count / 2);
  std::nth_element(sorted.begin(), middle, sorted.begin() + static_cast<std::ptrdiff_t>(count));
  return static_cast<double>(*middle);
}

void ForceExchange::settle_round_trip() noexcept {
  const double newest_s = find_round_trip_s();
  if (newest_s < 0.0) return;
  trips_s_.fill(static_cast<float>(newest_s));
  trip_count_ = kTrips;
}

void ForceExchange::note_local(const DeviceCycle& cycle, std::uint32_t view_revision) noexcept {
  if (!cycle.local) return;
  history_.note_local({.echo_sample = cycle.number,
                       .echo_sample_time_ns = cycle.sample.time_ns,
                       .force_n = cycle.local->force_n,
                       .visual_offset_m = cycle.local->visual_offset_m,
                       .contact = cycle.local->contact,
                       .view_revision = view_revision,
                       .object = cycle.local->object,
                       .scene_time_ns = std::max<std::int64_t>(cycle.local->scene_time_ns, 0),
                       .held_offset_m = cycle.local->held_offset_m});
}

void ForceExchange::on_haptics_joined() noexcept {
  trip_count_ = 0;
  history_.note_new_haptics();
  responses_.excuse_waiting();
}

}  // namespace hapton
