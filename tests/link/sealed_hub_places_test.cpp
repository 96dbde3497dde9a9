// Which session is dropped when all slots are taken, and what a node sends, to whom, also during a flood.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

#include "tests/link/sealed_hub_fixture.h"

namespace hapton::sealed_hub {
namespace {

class SealedHubSlots : public SealedHubTest {
 protected:
  // Joins this many haptics nodes, a role with few slots.
  void join_haptics(std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      nodes_.push_back(make_haptics(static_cast<std::uint8_t>(10 + i)));
      ASSERT_NO_FATAL_FAILURE(join(*nodes_.back()));
    }
  }
  std::unique_ptr<Node> make_haptics(std::uint8_t host) { return make_node(host, key_of(1), KeyRole::haptics); }
  // Runs all nodes except the silent ones.
  void run_for_without(std::initializer_list<std::size_t> silent, int ms) {
    std::vector<Node*> others;
    for (std::size_t n = 0; n < nodes_.size(); ++n) {
      if (std::find(silent.begin(), silent.end(), n) == silent.end()) others.push_back(nodes_[n].get());
    }
    run_for(others, ms);
  }

  static constexpr std::size_t kHapticsSlots = SealedHub::kRoleSlots[0];
  std::vector<std::unique_ptr<Node>> nodes_;
};

// However long ago it joined: otherwise any holder of the role's key could end the session of the node that moves the hand.
TEST_F(SealedHubSlots, ASessionInUseKeepsItsSlot) {
  join_haptics(kHapticsSlots);
  run_for_without({}, 3000);
  const auto late_node = make_haptics(200);
  node_sends(*late_node, "any room?");
  EXPECT_TRUE(run_handshake(*late_node).empty());
  EXPECT_GT(hub_->seal_counts().no_slot, 0U);
  for (const auto& node : nodes_) EXPECT_TRUE(hub_sends(*node, "you stay"));
}

TEST_F(SealedHubSlots, TheOneThatIsSilentLongestMakesRoom) {
  join_haptics(kHapticsSlots);
  run_for_without({5}, 300);
  run_for_without({5, 3}, 300);
  run_for_without({5, 3, 6}, 2200);
  const auto late_node = make_haptics(200);
  join(*late_node);
  for (std::size_t n = 0; n < nodes_.size(); ++n) EXPECT_EQ(hub_sends(*nodes_[n], "are you there?"), n != 5) << n;
}

// Its reply was lost, or the node is gone: it must not keep its slot for ever.
TEST_F(SealedHubSlots, ASessionThatWasNeverUsedMakesRoomForTheNext) {
  join_haptics(kHapticsSlots - 1);
  const auto lost_node = make_haptics(100);
  node_sends(*lost_node, "boo");
  hub_receives();             // its request gets a cookie
  node_receives(*lost_node);  // requests with the cookie
  hub_receives();             // gets a reply
  clock_.advance_ns(5 * kMs);
  const auto late_node = make_haptics(200);
  join(*late_node);
  for (const auto& node : nodes_) EXPECT_TRUE(hub_sends(*node, "you stay"));
  node_receives(*lost_node);  // has a session, and sends what waited
  EXPECT_TRUE(hub_receives().empty());
  EXPECT_EQ(hub_->seal_counts().unknown_session, 1U);
}

// Another program may get the address once nothing comes from it. What the hub then sends to the address is for that program alone.
TEST_F(SealedHubSlots, AnAddressThatIsSilentForLongMayBecomeAnotherRoles) {
  auto haptics = make_haptics(2);
  join(*haptics);
  haptics.reset();
  clock_.advance_ns(SealedHub::kIdleNs - 20 * kMs);  // join takes 20 ms after the last datagram
  const auto vision = make_node(2);
  node_sends(*vision, "hello");
  EXPECT_TRUE(run_handshake(*vision).empty());
  EXPECT_GT(hub_->seal_counts().no_slot, 0U);
  clock_.advance_ns(2 * SealedClient::kRequestPeriodNs);
  EXPECT_EQ(run_handshake(*vision).count("hello"), 1U);
  EXPECT_TRUE(hub_sends(*vision, "welcome"));
  EXPECT_EQ(node_receives(*vision), std::vector<std::string>{"welcome"});
}

// --- nodes

// An attacker who repeats a cookie from the hub's address must not make a node send a flood of requests, with a key pair for each.
TEST_F(SealedHubSlots, ARepeatedCookieIsWorthOneRequest) {
  const auto node = make_node(2);
  node_sends(*node, "first");
  hub_receives();        // its request gets a cookie
  node_receives(*node);  // requests with the cookie
  const Bytes cookie = node->endpoint.arrived().back().bytes;
  ASSERT_EQ(classify_sealed(cookie).kind, seal::Kind::retry);
  ASSERT_EQ(node->endpoint.sent(), 2U);
  for (int times = 0; times < 50; ++times) node->endpoint.inject(hub_address_, cookie);
  EXPECT_TRUE(node_receives(*node).empty());
  EXPECT_EQ(node->endpoint.sent(), 2U);
  EXPECT_EQ(node->sealed.seal_counts().wrong_key, 0U) << "it is the hub's";
  EXPECT_EQ(run_handshake(*node).count("first"), 1U);
}

TEST_F(SealedHubSlots, AFloodCannotBlockAPollOfANode) {
  const auto node = make_node(2);
  join(*node);
  for (int i = 0; i < 1000; ++i) node->endpoint.inject(hub_address_, Bytes(40, std::byte{1}));
  std::array<std::byte, kMaxDatagramBytes> into;
  EXPECT_EQ(node->sealed.receive(into, 0).bytes, 0U);
  EXPECT_GT(node->sealed.seal_counts().rejected(), 0U);
  EXPECT_LE(node->sealed.seal_counts().rejected(), 64U);
  ASSERT_TRUE(hub_sends(*node, "through it all"));
  EXPECT_GT(node->sealed.receive(into, clock_.now_ns() + 5 * kMs).bytes, 0U);
  EXPECT_EQ(node->sealed.seal_counts().rejected(), 1000U);
}

// The hub was restarted, and an attacker floods the node from the hub's address: there is always something to receive.
TEST_F(SealedHubSlots, AFloodDoesNotKeepANodeFromLookingForItsHub) {
  const auto node = make_node(2);
  join(*node);
  clock_.advance_ns(10'000 * kMs);
  const std::size_t before = node->endpoint.sent();
  for (int i = 0; i < 200; ++i) node->endpoint.inject(hub_address_, Bytes(40, std::byte{1}));
  std::array<std::byte, kMaxDatagramBytes> into;
  EXPECT_EQ(node->sealed.receive(into, 0).bytes, 0U);
  EXPECT_EQ(node->endpoint.sent(), before + 1);
}

TEST_F(SealedHubSlots, ANodeSendsToItsHubAloneAndOnlyWhatFits) {
  const auto node = make_node(2);
  const Bytes most(seal::kMaxPayloadBytes, std::byte{1});
  const Bytes too_long(seal::kMaxPayloadBytes + 1, std::byte{1});
  EXPECT_FALSE(node->sealed.send(hub_address_, too_long)) << "nor is it kept for the session";
  EXPECT_FALSE(node->sealed.send(memory_address(3, 9), most));
  EXPECT_EQ(node->endpoint.sent(), 0U);
  EXPECT_TRUE(node->sealed.send(hub_address_, most));
  EXPECT_EQ(run_handshake(*node).count(to_text(most)), 1U);
  EXPECT_FALSE(node->sealed.send(hub_address_, too_long));
  EXPECT_TRUE(hub_receives().empty());
}

}  // namespace
}  // namespace hapton::sealed_hub
