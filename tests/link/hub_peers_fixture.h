#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "link/hub_peers.h"
#include "link/memory_endpoint.h"
#include "tests/support/time_units.h"

namespace hapton::hub_peers {

using Kind = PeerEvent::Kind;

inline constexpr std::uint64_t kSession = 777;
inline constexpr double kRateHz = 1000.0;

// A peer whose datagrams the test makes.
struct RawNode {
  std::unique_ptr<Endpoint> endpoint;
  std::uint64_t sender = 0;
  std::uint64_t sequence = 0;
};

class HubPeersTest : public testing::Test {
 protected:
  HubPeersTest() { hub_.emplace(*hub_endpoint_, clock_, kSession, kRateHz); }

  RawNode raw_node(std::uint8_t host, std::uint64_t sender, std::uint16_t port = 9) {
    return {*network_.open(memory_address(host, port)), sender, 0};
  }

  void send(RawNode& node, const Message& message, std::uint64_t session = kSession) {
    Bytes bytes;
    const std::size_t size = codec_.encode({{session, node.sender, ++node.sequence, clock_.now_ns()}, message}, bytes);
    ASSERT_GT(size, 0U);
    node.endpoint->send(hub_endpoint_->local_address(), std::span(bytes).first(size));
  }

  // All events of the hub for the datagrams that have arrived, and its timeouts.
  std::vector<PeerEvent> take_events() {
    std::vector<PeerEvent> all;
    while (true) {
      const std::uint64_t before = hub_->counts().received;
      const PeerEvent event = hub_->receive(datagram_, 0);
      if (event.kind != Kind::none) {
        all.push_back(event);
      } else if (hub_->counts().received == before) {
        return all;
      }
    }
  }

  // As take_events(), where exactly one event is expected.
  PeerEvent take_only_event() {
    const std::vector<PeerEvent> all = take_events();
    EXPECT_EQ(all.size(), 1U);
    return all.empty() ? PeerEvent{} : all.front();
  }

  std::vector<Datagram> received_by(RawNode& node) {
    std::vector<Datagram> all;
    Bytes bytes;
    while (true) {
      const Received received = node.endpoint->receive(bytes, 0);
      if (received.bytes == 0) {
        return all;
      }
      Datagram datagram;
      EXPECT_EQ(codec_.decode(std::span(bytes).first(received.bytes), datagram), DecodeStatus::ok);
      all.push_back(datagram);
    }
  }

  using Bytes = std::array<std::byte, kMaxDatagramBytes>;

  SimulatedClock clock_;
  MemoryNetwork network_{clock_};
  std::unique_ptr<Endpoint> hub_endpoint_ = *network_.open(memory_address(1, 4950));
  std::optional<HubPeers> hub_;
  Codec codec_;
  Datagram datagram_;
};

}  // namespace hapton::hub_peers
