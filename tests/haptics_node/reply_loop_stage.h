#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "link/hub_client.h"
#include "link/hub_peers.h"
#include "link/memory_endpoint.h"
#include "runtime/clock.h"
#include "tests/support/time_units.h"

namespace hapton {

// The client of a haptics node, and a hub, on simulated time.
class ReplyLoopStage : public ::testing::Test {
 protected:
  // Called with each message that the hub has received.
  virtual void take(const Message& message) = 0;

  // Passes what the hub receives within a millisecond to take().
  void receive_at_hub() {
    const std::int64_t end_ns = clock_.now_ns() + kMs;
    Datagram datagram;
    while (clock_.now_ns() < end_ns) {
      if (hub_.receive(datagram, end_ns).kind != PeerEvent::Kind::message) continue;
      order_.push_back(datagram.message.index());
      take(datagram.message);
    }
  }
  void send(const Message& message) { hub_.send_to_role(NodeRole::haptics, message); }

  SimulatedClock clock_;
  MemoryNetwork network_{clock_};
  std::unique_ptr<Endpoint> hub_endpoint_ = *network_.open(memory_address(1, 4950));
  std::unique_ptr<Endpoint> endpoint_ = *network_.open(memory_address(2, 0));
  HubPeers hub_{*hub_endpoint_, clock_, 1, 1000.0};
  HubClient client_{*endpoint_, clock_, NodeRole::haptics, memory_address(1, 4950)};
  std::vector<std::size_t> order_;  // kinds of the messages received since this was cleared
};

}  // namespace hapton
