#include "io_node/hop_meter.h"

#include <algorithm>
#include <cstdlib>

#include "link/link_key.h"

namespace hapton {

void HopMeter::on_joined(std::size_t slot, const Address& address) noexcept {
  if (slot >= offsets_.size()) return;
  offsets_[slot].forget();
  is_one_clock_[slot] = is_loopback(address);
}

void HopMeter::on_state_sent(std::uint64_t sample, std::int64_t sample_time_ns) noexcept {
  states_[sample % kStatesKept] = {sample, endpoint_.last_send_ns()};
  stats_.encode.record(endpoint_.last_send_ns() - sample_time_ns);
}

void HopMeter::on_probe_sent(std::uint64_t sample) noexcept {
  SentSample& last = probes_[(next_probe_ + kProbesKept - 1) % kProbesKept];
  if (last.sample == sample) {  // sent again with changed statistics
    last.time_ns = endpoint_.last_send_ns();
    return;
  }
  probes_[next_probe_] = {sample, endpoint_.last_send_ns()};
  next_probe_ = (next_probe_ + 1) % kProbesKept;
}

void HopMeter::on_force(const Header& header, const ForceCommand& command, std::int64_t ready_ns) noexcept {
  const std::int64_t round_trip_ns = ready_ns - command.echo_sample_time_ns;
  if (last_round_trip_ns_ >= 0) stats_.jitter.record(std::abs(round_trip_ns - last_round_trip_ns_));
  last_round_trip_ns_ = round_trip_ns;
  const std::int64_t received_at_ns = endpoint_.last_receive_ns();
  stats_.decode.record(ready_ns - received_at_ns);
  const SentSample& sent = states_[command.echo_sample % kStatesKept];
  if (sent.sample != command.echo_sample || sent.sample == 0) return;
  // The node reports how long it held the sample, so the time of its reply gives the arrival of the sample. Invalid times of a node are
  // ignored here and in ClockOffset.
  std::int64_t arrived_ns = 0;
  if (__builtin_sub_overflow(header.send_time_ns, static_cast<std::int64_t>(command.compute_ns), &arrived_ns)) return;
  ClockOffset& offset = offsets_[HubPeers::kHapticsSlot];
  offset.add({sent.time_ns, arrived_ns, header.send_time_ns, received_at_ns});
  if (!is_offset_known(HubPeers::kHapticsSlot)) return;
  const std::int64_t ahead_ns = offset_ns(HubPeers::kHapticsSlot);
  const std::int64_t wire_ns = received_at_ns - sent.time_ns - static_cast<std::int64_t>(command.compute_ns);
  std::int64_t out_ns = 0;
  if (__builtin_sub_overflow(arrived_ns, sent.time_ns + ahead_ns, &out_ns)) return;
  if (out_ns < 0 || out_ns > wire_ns) return;  // the clock offset is not known well enough for this round trip
  stats_.wire_out.record(out_ns);
  stats_.wire_back.record(wire_ns - out_ns);
}

void HopMeter::on_frame_ack(const Header& header, const FrameAck& frame, std::size_t slot) noexcept {
  const auto probe = std::find_if(probes_.begin(), probes_.end(), [&](const SentSample& sent) { return sent.sample == frame.echo_sample; });
  if (frame.held_ns == 0 || frame.echo_sample == 0 || slot >= offsets_.size() || probe == probes_.end()) return;
  std::int64_t received_ns = 0;
  if (__builtin_sub_overflow(header.send_time_ns, static_cast<std::int64_t>(frame.held_ns), &received_ns)) return;
  stats_.vision_draw.record(frame.held_ns);
  offsets_[slot].add({probe->time_ns, received_ns, header.send_time_ns, endpoint_.last_receive_ns()});
  if (!is_offset_known(slot)) return;
  std::int64_t photon_ns = 0;
  const bool overflows = __builtin_sub_overflow(header.send_time_ns, offset_ns(slot) + frame.echo_sample_time_ns, &photon_ns);
  if (!overflows && photon_ns >= 0 && photon_ns <= endpoint_.last_receive_ns() - frame.echo_sample_time_ns)
    stats_.motion_to_photon.record(photon_ns);
}

const HopStats& HopMeter::collect(std::int64_t now_ns) noexcept {
  const ClockOffset& offset = offsets_[HubPeers::kHapticsSlot];
  stats_.link = endpoint_.counts();
  stats_.is_one_clock = is_one_clock_[HubPeers::kHapticsSlot];
  // The estimate is reported even where it is not needed, to show its accuracy.
  stats_.is_offset_known = offset.is_known();
  stats_.clock_offset_ns = offset.is_known() ? offset.offset_ns() : 0;
  stats_.clock_error_ns = offset.is_known() ? offset.error_bound_ns(now_ns) : 0;
  return stats_;
}

}  // namespace hapton
