#pragma once

#include <cstddef>
#include <cstdint>

#include "io_node/device_loop.h"
#include "io_node/probe_memory.h"
#include "io_node/servo_stats.h"
#include "io_node/vision_pace.h"
#include "io_node/way_meter.h"
#include "link/hub_peers.h"
#include "link/messages.h"

namespace hapton {

// What the vision nodes are told: the probe, each at its own pace, and what they say of their pictures. What it measures goes into the
// servo's stats.
// Units: ns of the hub's clock. RT: yes. Threads: one.
class VisionFeed {
 public:
  // Pre: peers and stats outlive this. rate_hz: states a second to each node, at most; 0: none.
  VisionFeed(HubPeers& peers, ServoStats& stats, double rate_hz) noexcept : peers_(peers), stats_(stats), pace_(rate_hz) {}

  void set_way_meter(WayMeter* ways) noexcept { ways_ = ways; }
  void start(std::int64_t now_ns) noexcept { figures_since_ns_ = now_ns; }

  void on_joined(std::size_t peer) noexcept { pace_.on_joined(peer); }
  // newest_sample: of this session. A word about a state that was never sent is passed over.
  void on_drawn(const Header& header, const Drawn& drawn, std::size_t peer, std::uint64_t newest_sample, std::int64_t now_ns) noexcept;
  // Once a cycle: those whose turn it is.
  void tell(const ProbeMemory& memory, const DeviceSide& side, const DeviceCycle& cycle, std::uint32_t view_revision, ProbeStatus status,
            std::int64_t now_ns) noexcept;
  // Now and then: the rate and the round trip that people read in the picture.
  void refresh_figures(std::uint64_t newest_sample, std::int64_t now_ns) noexcept;

 private:
  HubPeers& peers_;
  ServoStats& stats_;
  WayMeter* ways_ = nullptr;
  VisionPace pace_;
  ProbeState probe_;
  std::int64_t figures_since_ns_ = 0;
  std::uint64_t figures_samples_ = 0;
};

}  // namespace hapton
