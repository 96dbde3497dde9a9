#include "io_node/vision_feed.h"

#include <algorithm>
#include <cmath>

namespace hapton {
namespace {

std::uint32_t percent_of(double share) { return static_cast<std::uint32_t>(std::lround(100.0 * std::clamp(share, 0.0, 10.0))); }

}  // namespace

void VisionFeed::on_frame_ack(const Header& header, const FrameAck& frame, std::size_t peer, std::uint64_t newest_sample,
                              std::int64_t now_ns) noexcept {
  const std::int64_t age_ns = now_ns - frame.echo_sample_time_ns;
  const bool is_ours =
      frame.echo_sample != 0 && frame.echo_sample <= newest_sample && age_ns >= 0 && frame.echo_sample_time_ns >= stats_.start_ns;
  if (!is_ours) return;
  pace_.on_frame_ack(peer, frame, now_ns);
  if (frame.unchanged || frame.every_sample) return;  // no frame was drawn that could be measured
  ++stats_.drawn;
  stats_.device_to_drawn.record(age_ns);
  if (hops_ != nullptr) hops_->on_frame_ack(header, frame, peer);
  stats_.frame_rate_hz = static_cast<double>(frame.frame_rate_hz);
}

void VisionFeed::send(const ProbeHistory& history, const DeviceSide& side, const DeviceCycle& cycle, std::uint32_t view_revision,
                      ProbeStatus status, std::int64_t now_ns) noexcept {
  history.show(side.has_timed_out, probe_);
  probe_.buttons = cycle.sample.buttons;
  probe_.force_n = side.written.force_n;
  probe_.torque_nm = side.written.torque_nm;
  probe_.view_revision = view_revision;
  probe_.status = status;
  probe_.energy_percent = percent_of(side.governor.energy_share());
  std::size_t reached = 0;
  for (std::size_t slot = 0; slot < HubPeers::kCapacity; ++slot) {
    const Peer& peer = peers_.peer(slot);
    if (!peer.present || peer.role != NodeRole::vision) continue;
    const VisionPace::Decision decision = pace_.decide(slot, probe_, now_ns);
    stats_.probe_states_unchanged += decision == VisionPace::Decision::skip ? 1 : 0;
    if (decision == VisionPace::Decision::send) reached += peers_.send_to(slot, probe_) ? 1 : 0;
  }
  stats_.probe_states_sent += reached;
  if (hops_ != nullptr && reached > 0) hops_->on_probe_sent(probe_.sample);
}

void VisionFeed::refresh_statistics(std::uint64_t newest_sample, std::int64_t now_ns) noexcept {
  const double passed_s = 1e-9 * static_cast<double>(now_ns - statistics_since_ns_);
  if (passed_s > 0.0) probe_.servo_rate_hz = static_cast<float>(static_cast<double>(newest_sample - statistics_samples_) / passed_s);
  statistics_since_ns_ = now_ns;
  statistics_samples_ = newest_sample;
  const bool has_haptics = peers_.has_haptics();
  probe_.round_trip_p50_us = has_haptics ? static_cast<float>(1e-3 * stats_.round_trip.quantile_ns(0.5)) : 0.0F;
  probe_.round_trip_p99_us = has_haptics ? static_cast<float>(1e-3 * stats_.round_trip.quantile_ns(0.99)) : 0.0F;
  // Late replies are the reason why there is no force: show the newest round trip, and not the median, which includes better times.
  if (has_haptics && stats_.are_replies_late()) probe_.round_trip_p50_us = static_cast<float>(1e6 * stats_.newest_round_trip_s);
}

}  // namespace hapton
