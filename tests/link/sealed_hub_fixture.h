#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "link/memory_endpoint.h"
#include "link/sealed_client.h"
#include "link/sealed_hub.h"
#include "tests/link/tapped_endpoint.h"
#include "tests/support/time_units.h"

// A hub and its nodes over a network in memory, with an eavesdropper: the fixture of the SealedHub tests.
namespace hapton::sealed_hub {

using Bytes = std::vector<std::byte>;

inline LinkKey key_of(std::uint8_t number) {
  EXPECT_TRUE(seal::start_crypto());
  LinkKey::Bytes bytes;
  bytes.fill(number);
  return LinkKey(bytes);
}

inline Bytes to_bytes(const std::string& text) {
  Bytes bytes(text.size());
  std::transform(text.begin(), text.end(), bytes.begin(), [](char c) { return static_cast<std::byte>(c); });
  return bytes;
}

inline std::string to_text(std::span<const std::byte> bytes) {
  std::string text;
  for (const std::byte byte : bytes) text += static_cast<char>(byte);
  return text;
}

// A node with a sealed connection to the hub. Each address is a host of its own.
struct Node {
  Node(MemoryNetwork& network, const Clock& clock, const Address& at, const Address& hub, const RoleKey& key)
      : endpoint(*network.open(at)), sealed(endpoint, clock, key, hub, {.host = at.ip[15]}) {}

  TappedEndpoint endpoint;
  SealedClient sealed;
};

class SealedHubTest : public testing::Test {
 protected:
  SealedHubTest() : hub_endpoint_(*network_.open(memory_address(1, 4950))) { start_hub(); }

  void start_hub(const LinkKey& key = key_of(1)) { hub_.emplace(hub_endpoint_, clock_, key); }

  std::unique_ptr<Node> make_node(std::uint8_t host, const LinkKey& key = key_of(1), KeyRole role = KeyRole::vision) {
    return std::make_unique<Node>(network_, clock_, memory_address(host, 9), hub_address_, RoleKey(key, role));
  }

  // All datagrams that the hub opens now: the text of each, with its sender.
  std::multimap<std::string, Address> hub_receives() {
    std::multimap<std::string, Address> all;
    std::array<std::byte, kMaxDatagramBytes> into;
    for (Received received = hub_->receive(into, 0); received.bytes != 0; received = hub_->receive(into, 0)) {
      all.emplace(to_text(std::span(into).first(received.bytes)), received.from);
    }
    return all;
  }

  static std::vector<std::string> node_receives(Node& node) {
    std::vector<std::string> all;
    std::array<std::byte, kMaxDatagramBytes> into;
    for (Received received = node.sealed.receive(into, 0); received.bytes != 0; received = node.sealed.receive(into, 0)) {
      all.push_back(to_text(std::span(into).first(received.bytes)));
    }
    return all;
  }

  void node_sends(Node& node, const std::string& text) { EXPECT_TRUE(node.sealed.send(hub_address_, to_bytes(text))); }
  bool hub_sends(const Node& node, const std::string& text) { return hub_->send(node.endpoint.local_address(), to_bytes(text)); }

  // Runs the handshake until both have no more of its messages to send. Returns what the hub has received meanwhile.
  std::multimap<std::string, Address> run_handshake(Node& node) {
    std::multimap<std::string, Address> all;
    for (int turn = 0; turn < 4; ++turn) {
      all.merge(hub_receives());
      node_receives(node);
    }
    clock_.advance_ns(20 * kMs);  // lets the handshake rates recover
    return all;
  }

  void join(Node& node) {
    node_sends(node, "first");
    ASSERT_EQ(run_handshake(node).count("first"), 1U);
    ASSERT_TRUE(hub_sends(node, "welcome"));
    ASSERT_EQ(node_receives(node), std::vector<std::string>{"welcome"});
  }

  // Runs for these milliseconds: the nodes send and receive like HubClient, the hub replies to every datagram.
  void run_for(std::vector<Node*> nodes, int ms) {
    for (int i = 0; i < ms; ++i) {
      clock_.advance_ns(kMs);
      for (Node* node : nodes) {
        if (i % 100 == 0) node_sends(*node, "hello");
      }
      for (const auto& [text, from] : hub_receives()) hub_->send(from, to_bytes("re " + text));
      for (Node* node : nodes) replies_ += static_cast<int>(node_receives(*node).size());
    }
  }

  SimulatedClock clock_{1000 * kNanosecondsPerSecond};
  MemoryNetwork network_{clock_};
  Address hub_address_ = memory_address(1, 4950);
  TappedEndpoint hub_endpoint_;
  std::optional<SealedHub> hub_;
  int replies_ = 0;
};

}  // namespace hapton::sealed_hub
