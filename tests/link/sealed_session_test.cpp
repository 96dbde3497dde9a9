// Nodes join a hub, leave and come back, as in hub_client_test.cpp, but with sealed datagrams.
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <vector>

#include "link/hub_client.h"
#include "link/hub_peers.h"
#include "link/memory_endpoint.h"
#include "link/sealed_client.h"
#include "link/sealed_hub.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

LinkKey key_of(std::uint8_t number) {
  EXPECT_TRUE(seal::start_crypto());
  LinkKey::Bytes bytes;
  bytes.fill(number);
  return LinkKey(bytes);
}

class SealedSessionTest : public testing::Test {
 protected:
  struct Node {
    Node(SealedSessionTest& test, std::uint8_t host, NodeRole role, const LinkKey& key)
        : endpoint(*test.network_.open(memory_address(host, 0))),
          sealed(*endpoint, test.clock_, RoleKey(key, key_role(role)), test.hub_address_, {.host = host}),
          client(sealed, test.clock_, role, test.hub_address_) {}

    static KeyRole key_role(NodeRole role) { return role == NodeRole::haptics ? KeyRole::haptics : KeyRole::vision; }

    std::unique_ptr<Endpoint> endpoint;
    SealedClient sealed;
    HubClient client;
    int states = 0;
  };

  std::unique_ptr<Node> make_node(std::uint8_t host, NodeRole role = NodeRole::haptics, std::uint8_t key = 1) {
    return std::make_unique<Node>(*this, host, role, key_of(key));
  }

  void start_hub() {
    peers_.reset();
    sealed_.emplace(*hub_endpoint_, clock_, key_of(1));
    peers_.emplace(*sealed_, clock_, ++session_, 1000.0);
  }
  // The hub ends without a Bye, and its session keys are lost.
  void crash_hub() {
    network_.set_impairments({.loss = 1.0});
    peers_.reset();
    sealed_.reset();
    network_.set_impairments(impairments_);
  }

  // Runs the hub and the nodes in steps of 1 ms: in each the hub sends one state, to which each haptics node replies.
  void run(const std::vector<Node*>& nodes, int ms) {
    for (int i = 0; i < ms; ++i) {
      clock_.advance_ns(kMs);
      for (int turn = 0; turn < 3; ++turn) {
        if (peers_) turn_hub(turn == 0);
        for (Node* node : nodes) turn_node(*node);
      }
    }
  }

  void turn_hub(bool sends) {
    Datagram datagram;
    std::uint64_t before = 0;
    do {
      before = peers_->counts().received;
      replies_ += peers_->receive(datagram, 0).kind == PeerEvent::Kind::message ? 1 : 0;
    } while (peers_->counts().received != before);
    if (sends) peers_->send_to_role(NodeRole::haptics, DeviceState{.sample = ++sample_});
  }

  static void turn_node(Node& node) {
    Datagram datagram;
    while (node.client.receive(datagram, 0)) {
      if (std::holds_alternative<DeviceState>(datagram.message)) {
        ++node.states;
        node.client.send(ForceCommand{.echo_sample = 1});
      }
    }
  }

  Impairments impairments_;
  SimulatedClock clock_{1000 * kNanosecondsPerSecond};
  MemoryNetwork network_{clock_};
  Address hub_address_ = memory_address(1, 4950);
  std::unique_ptr<Endpoint> hub_endpoint_ = *network_.open(hub_address_);
  std::optional<SealedHub> sealed_;
  std::optional<HubPeers> peers_;
  std::uint64_t session_ = 0;
  std::uint64_t sample_ = 0;
  int replies_ = 0;
};

TEST_F(SealedSessionTest, ANodeJoinsAtOnce) {
  start_hub();
  const auto node = make_node(2);
  run({node.get()}, 3);
  EXPECT_EQ(node->client.state(), JoinState::joined);
  EXPECT_GT(replies_, 0);
}

TEST_F(SealedSessionTest, ANodeJoinsAsSoonAsItsHubIsThere) {
  const auto node = make_node(2);
  run({node.get()}, 1030);
  EXPECT_EQ(node->client.state(), JoinState::joining);
  start_hub();
  run({node.get()}, 55);
  EXPECT_EQ(node->client.state(), JoinState::joined);
}

TEST_F(SealedSessionTest, ANodeThatLeftIsServedAtOnceWhenItIsBack) {
  start_hub();
  auto first = make_node(2);
  run({first.get()}, 500);
  first.reset();
  const auto second = make_node(2);
  run({second.get()}, 3);
  EXPECT_EQ(second->client.state(), JoinState::joined);
  EXPECT_GT(second->states, 0);
}

TEST_F(SealedSessionTest, ACrashedNodesSuccessorHasItsSlotWithin150Milliseconds) {
  start_hub();
  auto first = make_node(2);
  run({first.get()}, 500);
  network_.set_impairments({.loss = 1.0});
  first.reset();
  network_.set_impairments({});
  const auto second = make_node(3);
  run({second.get()}, 152);
  EXPECT_EQ(second->client.state(), JoinState::joined);
  EXPECT_GT(second->states, 0);
}

TEST_F(SealedSessionTest, ARestartedHubHasItsNodesBackWithin300MillisecondsOfItsDeath) {
  start_hub();
  const auto haptics = make_node(2);
  const auto vision = make_node(3, NodeRole::vision);
  run({haptics.get(), vision.get()}, 1000);
  crash_hub();
  run({haptics.get(), vision.get()}, 20);
  start_hub();
  run({haptics.get(), vision.get()}, 280);
  EXPECT_EQ(peers_->count(NodeRole::haptics), 1U);
  EXPECT_EQ(peers_->count(NodeRole::vision), 1U);
  EXPECT_EQ(haptics->client.session(), session_);
  EXPECT_EQ(vision->client.session(), session_);
}

TEST_F(SealedSessionTest, AHubGoneForLongIsJoinedSoonAfterItsReturn) {
  start_hub();
  const auto node = make_node(2);
  run({node.get()}, 500);
  crash_hub();
  run({node.get()}, 10'000);
  EXPECT_EQ(node->client.state(), JoinState::joining);
  start_hub();
  node->states = 0;
  run({node.get()}, 160);
  EXPECT_EQ(node->client.state(), JoinState::joined);
  EXPECT_GT(node->states, 50);
}

TEST_F(SealedSessionTest, ASecondHapticsNodeIsNotifiedThatTheSlotIsTaken) {
  start_hub();
  const auto first = make_node(2);
  const auto second = make_node(3);
  run({first.get(), second.get()}, 500);
  EXPECT_EQ(first->client.state(), JoinState::joined);
  EXPECT_EQ(second->client.state(), JoinState::rejected);
}

TEST_F(SealedSessionTest, AnUnknownPeerLearnsNothingAndDisturbsNoOther) {
  start_hub();
  const auto node = make_node(2);
  const auto unknown = make_node(3, NodeRole::haptics, 2);
  run({node.get(), unknown.get()}, 2000);
  EXPECT_EQ(unknown->client.state(), JoinState::joining);
  EXPECT_EQ(unknown->sealed.seal_counts().opened, 0U);
  EXPECT_EQ(node->client.state(), JoinState::joined);
  EXPECT_NEAR(replies_, 2000, 10);
  EXPECT_NEAR(static_cast<double>(sealed_->seal_counts().wrong_key), 40.0, 2.0) << "a request every 50 ms";
  EXPECT_EQ(peers_->counts().received, sealed_->seal_counts().opened);
}

TEST_F(SealedSessionTest, ABadNetworkCostsDatagramsButNoSession) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(seed);
    impairments_ = {.seed = seed, .loss = 0.3, .duplicate = 0.05, .reorder = 0.2, .jitter_ns = 20 * kMs};
    network_.set_impairments(impairments_);
    start_hub();
    const auto node = make_node(2);
    run({node.get()}, 1000);
    node->states = 0;
    run({node.get()}, 3000);
    EXPECT_EQ(node->client.state(), JoinState::joined);
    EXPECT_NEAR(node->states, 0.7 * 3000, 0.05 * 3000);
    EXPECT_EQ(node->sealed.seal_counts().forged + sealed_->seal_counts().forged, 0U);
    EXPECT_LE(node->client.counts().joins, 2U);
  }
}

}  // namespace
}  // namespace hapton
