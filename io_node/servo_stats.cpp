#include "io_node/servo_stats.h"

namespace hapton {

void add_device_stats(const DeviceLoopStats& device, ServoStats& stats) noexcept {
  stats.start_ns = device.start_ns;
  stats.end_ns = device.end_ns;
  stats.rate_hz = device.rate_hz;
  stats.wake_lateness = device.wake_lateness;
  stats.device_read = device.device_read;
  stats.samples = device.samples;
  stats.missed_cycles = device.missed_cycles;
  stats.caught_up_cycles = device.caught_up_cycles;
  stats.missed_by_cause = device.missed_by_cause;
  stats.max_force_n = device.max_force_n;
  stats.max_torque_nm = device.max_torque_nm;
  stats.longest_release_ns = device.longest_release_ns;
  stats.governor = device.governor;
  stats.device_status = device.status;
  stats.device = device.condition;
  stats.resets_denied = device.resets_denied;
  stats.cuts = device.cuts;
  stats.local_forces = device.local_forces;
  stats.cycles_unreported = device.cycles_unreported;
}

void add_peer_stats(const HubPeers& peers, ServoStats& stats) noexcept {
  stats.hub = peers.counts();
  stats.seal = peers.seal_counts();
  for (std::size_t slot = 0; slot < HubPeers::kCapacity; ++slot) {
    const Peer& peer = peers.peer(slot);
    stats.peers[slot] = {peer.present, peer.role, peer.address, peer.joined_ns, peer.sent, peer.send_failures, peer.tracker.counts()};
  }
}

}  // namespace hapton
