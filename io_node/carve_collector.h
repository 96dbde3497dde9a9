#pragma once

#include <cstdint>

#include "io_node/servo_tap.h"
#include "link/hub_peers.h"
#include "link/known_carves.h"
#include "link/messages.h"

namespace hapton {

// While the session is recorded, requests from the haptics node the carves that it made before the recording began and those whose
// datagrams were lost, as a vision node does. So a recording has every carve, and its replay begins with the bodies as they were. Units:
// ns of the hub's clock. RT: yes. Threads: the network side's.
class CarveCollector {
 public:
  // Pre: both outlive this; tap may be null.
  CarveCollector(HubPeers& peers, const ServoTap* tap) noexcept : peers_(peers), tap_(tap) {}

  void note(const Carves& carves, Arrival arrival) noexcept { known_.take(carves, arrival); }
  void request_if_due(std::int64_t now_ns) noexcept {
    if (tap_ == nullptr || !tap_->is_recording() || !peers_.has_haptics()) return;
    if (const auto request = known_.take_request(now_ns)) peers_.send_to_role(NodeRole::haptics, *request);
  }

 private:
  HubPeers& peers_;
  const ServoTap* tap_;
  KnownCarves known_;
};

}  // namespace hapton
