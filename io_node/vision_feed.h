#pragma once

#include <cstddef>
#include <cstdint>

#include "io_node/device_loop.h"
#include "io_node/hop_meter.h"
#include "io_node/probe_history.h"
#include "io_node/servo_stats.h"
#include "io_node/vision_pace.h"
#include "link/hub_peers.h"
#include "link/messages.h"

namespace hapton {

// Sends the probe to the vision nodes, each at its own rate, and evaluates their frame acknowledgements. Measurements go into
// ServoStats. Units: ns of the hub's clock. RT: yes. Threads: one.
class VisionFeed {
 public:
  // Pre: peers and stats outlive this. rate_hz, ignored_buttons: see VisionPace.
  VisionFeed(HubPeers& peers, ServoStats& stats, double rate_hz, std::uint32_t ignored_buttons = 0) noexcept
      : peers_(peers), stats_(stats), pace_(rate_hz, ignored_buttons) {}

  void set_hop_meter(HopMeter* hops) noexcept { hops_ = hops; }
  // The largest force that the device may get, to be shown in the picture.
  void set_force_limit(double limit_n) noexcept { probe_.force_limit_n = static_cast<float>(limit_n); }
  void start(std::int64_t now_ns) noexcept { statistics_since_ns_ = now_ns; }

  void on_joined(std::size_t peer) noexcept { pace_.on_joined(peer); }
  // newest_sample: number of the newest sample. An acknowledgement of a sample that is newer, or from before the start, is ignored.
  void on_frame_ack(const Header& header, const FrameAck& frame, std::size_t peer, std::uint64_t newest_sample,
                    std::int64_t now_ns) noexcept;
  // Call once a cycle. Sends the state to the nodes for which it is due.
  void send(const ProbeHistory& history, const DeviceSide& side, const DeviceCycle& cycle, std::uint32_t view_revision, ProbeStatus status,
            std::int64_t now_ns) noexcept;
  // Call periodically. Updates the servo rate and the round trip that the picture shows.
  void refresh_statistics(std::uint64_t newest_sample, std::int64_t now_ns) noexcept;

 private:
  HubPeers& peers_;
  ServoStats& stats_;
  HopMeter* hops_ = nullptr;
  VisionPace pace_;
  ProbeState probe_;
  std::int64_t statistics_since_ns_ = 0;
  std::uint64_t statistics_samples_ = 0;
};

}  // namespace hapton
