#pragma once

#include <cstdint>
#include <string_view>

#include "io_node/servo_stats.h"
#include "link/hub_peers.h"
#include "link/messages.h"
#include "runtime/clock.h"

namespace hapton {

// Reports device, rate and round trip to the haptics node once a second, so that it can warn of a scene that is too stiff for them.
// Units: ns of the hub's clock. RT: yes. Threads: the network side's.
class LoopReporter {
 public:
  static constexpr std::int64_t kEveryNs = kNanosecondsPerSecond;
  static constexpr std::uint64_t kMinTrips = 2000;  // round trips: enough for a p99

  // max_torque_nm: of the device; 0: no motor turns the stylus. Pre: peers and stats outlive this.
  LoopReporter(HubPeers& peers, const ServoStats& stats, std::string_view device, double max_torque_nm) noexcept;

  void send_if_due(double rate_hz, std::int64_t now_ns) noexcept;

 private:
  HubPeers& peers_;
  const ServoStats& stats_;
  LoopFacts facts_;
  std::int64_t next_ns_ = 0;
};

}  // namespace hapton
