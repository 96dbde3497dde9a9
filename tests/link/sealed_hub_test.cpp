#include "link/sealed_hub.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "link/codec.h"
#include "link/memory_endpoint.h"
#include "link/sealed_client.h"
#include "tests/link/sealed_hub_fixture.h"
#include "tests/support/allocation_guard.h"

namespace hapton::sealed_hub {
namespace {

TEST_F(SealedHubTest, TheFirstMessageWaitsForASession) {
  const auto node = make_node(2);
  node_sends(*node, "hello hub");
  EXPECT_EQ(run_handshake(*node).count("hello hub"), 1U);
  EXPECT_TRUE(hub_sends(*node, "hello node"));
  EXPECT_EQ(node_receives(*node), std::vector<std::string>{"hello node"});
  EXPECT_EQ(hub_->seal_counts().handshakes, 1U);
  EXPECT_EQ(node->sealed.seal_counts().handshakes, 1U);
  EXPECT_EQ(hub_->seal_counts().rejected(), 0U);
}

TEST_F(SealedHubTest, NoWordIsReadableOnTheWire) {
  const auto node = make_node(2);
  node_sends(*node, "a very plain secret");
  run_handshake(*node);
  for (const auto& arrived : hub_endpoint_.arrived()) EXPECT_EQ(to_text(arrived.bytes).find("plain"), std::string::npos);
}

TEST_F(SealedHubTest, ManyNodesHaveKeysOfTheirOwn) {
  std::vector<std::unique_ptr<Node>> nodes;
  for (std::uint8_t i = 0; i < 16; ++i) nodes.push_back(make_node(static_cast<std::uint8_t>(10 + i)));
  for (const auto& node : nodes) join(*node);
  for (const auto& node : nodes) EXPECT_TRUE(hub_sends(*node, "to you"));
  for (const auto& node : nodes) EXPECT_EQ(node_receives(*node), std::vector<std::string>{"to you"});
  // No other node can open a datagram to one node.
  ASSERT_TRUE(hub_sends(*nodes[0], "yours alone"));
  node_receives(*nodes[0]);
  nodes[1]->endpoint.inject(hub_address_, nodes[0]->endpoint.arrived().back().bytes);
  EXPECT_TRUE(node_receives(*nodes[1]).empty());
  EXPECT_GT(nodes[1]->sealed.seal_counts().rejected(), 0U);
}

TEST_F(SealedHubTest, WithAnotherKeyThereIsNoReplyAndACount) {
  const auto outsider = make_node(2, key_of(2));
  node_sends(*outsider, "let me in");
  const std::size_t before = hub_endpoint_.sent();
  EXPECT_TRUE(run_handshake(*outsider).empty());
  EXPECT_EQ(hub_endpoint_.sent(), before);
  EXPECT_GT(hub_->seal_counts().wrong_key, 0U);
  EXPECT_FALSE(hub_sends(*outsider, "no"));
}

// Whoever can send from the hub's address can forge replies: a waiting node counts them, and joins nevertheless.
TEST_F(SealedHubTest, AForgedReplyToAHandshakeIsCountedAndHarmless) {
  const auto node = make_node(2);
  node_sends(*node, "first");
  const auto forge = [&](seal::Kind kind, std::size_t size) {
    Bytes forged(size, std::byte{0x5A});
    std::fill_n(forged.begin() + seal::kRoleAt + 1, 3, std::byte{0});  // the spare bytes of a request, which are always zero
    seal::write_lead(kind, seal::bytes_of(std::span(forged)));
    node->endpoint.inject(hub_address_, forged);
    EXPECT_TRUE(node_receives(*node).empty());
  };
  const std::size_t sent = node->endpoint.sent();
  forge(seal::Kind::reply, seal::kReplyBytes);
  EXPECT_EQ(node->sealed.seal_counts().wrong_key, 1U);
  forge(seal::Kind::retry, seal::kRetryBytes);
  EXPECT_EQ(node->sealed.seal_counts().wrong_key, 2U);
  forge(seal::Kind::request, seal::kRequestBytes);
  EXPECT_EQ(node->sealed.seal_counts().wrong_key, 3U) << "a hub requests nothing";
  EXPECT_EQ(node->endpoint.sent(), sent) << "and none gets a reply";
  EXPECT_EQ(run_handshake(*node).count("first"), 1U);
  EXPECT_EQ(node->sealed.seal_counts().wrong_key, 3U);
  EXPECT_EQ(node->sealed.seal_counts().handshakes, 1U);
  // Outside a handshake a late reply is not a fault.
  forge(seal::Kind::reply, seal::kReplyBytes);
  EXPECT_EQ(node->sealed.seal_counts().wrong_key, 3U);
  EXPECT_EQ(node->sealed.seal_counts().unknown_session, 0U);
  ASSERT_TRUE(hub_sends(*node, "welcome"));
  EXPECT_EQ(node_receives(*node), std::vector<std::string>{"welcome"});
  node->endpoint.inject(memory_address(66, 6), node->endpoint.arrived().back().bytes);
  EXPECT_TRUE(node_receives(*node).empty()) << "from another address";
  EXPECT_EQ(node->sealed.seal_counts().unknown_session, 1U);
}

TEST_F(SealedHubTest, AnotherVersionAndJunkGetNoReplyAndACount) {
  const Address from = memory_address(9, 9);
  hub_endpoint_.inject(from, {std::byte{0x08}, std::byte{0x01}, std::byte{0x42}});
  hub_endpoint_.inject(from, to_bytes("GET / HTTP/1.1"));
  hub_endpoint_.inject(from, Bytes(1));
  Bytes data(100);
  data[0] = std::byte{0x08};
  data[1] = std::byte{kProtocolVersion};
  data[2] = static_cast<std::byte>(seal::Kind::data);
  hub_endpoint_.inject(from, data);
  EXPECT_TRUE(hub_receives().empty());
  EXPECT_EQ(hub_endpoint_.sent(), 0U);
  EXPECT_EQ(hub_->seal_counts().wrong_version, 1U);
  EXPECT_EQ(hub_->seal_counts().malformed, 2U);
  EXPECT_EQ(hub_->seal_counts().unknown_session, 1U);
}

TEST_F(SealedHubTest, ARecordedDatagramIsNotAcceptedAgain) {
  const auto node = make_node(2);
  join(*node);
  node_sends(*node, "open the gate");
  EXPECT_EQ(hub_receives().count("open the gate"), 1U);
  const auto recorded = hub_endpoint_.arrived();
  const SealCounts before = hub_->seal_counts();
  for (int times = 0; times < 3; ++times) {
    for (const auto& arrived : recorded) hub_endpoint_.inject(arrived.from, arrived.bytes);
    EXPECT_TRUE(hub_receives().empty());
  }
  EXPECT_GT(hub_->seal_counts().replayed, before.replayed);
  EXPECT_EQ(hub_->seal_counts().replayed_handshakes, before.replayed_handshakes + 6);
  // The session continues.
  node_receives(*node);
  node_sends(*node, "still here");
  EXPECT_EQ(hub_receives().count("still here"), 1U);
  EXPECT_TRUE(hub_sends(*node, "yes"));
  EXPECT_EQ(node_receives(*node), std::vector<std::string>{"yes"});
}

TEST_F(SealedHubTest, AWholeRecordedSessionOpensNothingOnARestartedHub) {
  auto node = make_node(2);
  join(*node);
  node_sends(*node, "open the gate");
  hub_receives();
  const auto recorded = hub_endpoint_.arrived();
  node.reset();
  start_hub();
  for (const auto& arrived : recorded) hub_endpoint_.inject(arrived.from, arrived.bytes);
  EXPECT_TRUE(hub_receives().empty());
  EXPECT_EQ(hub_->seal_counts().handshakes, 0U);
}

TEST_F(SealedHubTest, ARecordedHandshakeDoesNotEndALiveSession) {
  auto first = make_node(2);
  join(*first);
  const auto recorded = hub_endpoint_.arrived();
  // The same node, restarted: its new session is the live one now.
  first.reset();
  const auto second = make_node(2);
  join(*second);
  EXPECT_EQ(hub_->seal_counts().handshakes, 2U);
  for (int times = 0; times < 20; ++times) {
    for (const auto& arrived : recorded) hub_endpoint_.inject(arrived.from, arrived.bytes);
    EXPECT_TRUE(hub_receives().empty());
    node_receives(*second);
    node_sends(*second, "here");
    EXPECT_EQ(hub_receives().count("here"), 1U);
    EXPECT_TRUE(hub_sends(*second, "good"));
    EXPECT_EQ(node_receives(*second), std::vector<std::string>{"good"});
  }
  EXPECT_EQ(hub_->seal_counts().handshakes, 2U);
}

TEST_F(SealedHubTest, ReflectedDatagramsAreNotAccepted) {
  const auto node = make_node(2);
  join(*node);
  node_sends(*node, "up");
  EXPECT_EQ(hub_receives().size(), 1U);
  node->endpoint.inject(hub_address_, hub_endpoint_.arrived().back().bytes);
  EXPECT_TRUE(node_receives(*node).empty());
  EXPECT_EQ(node->sealed.seal_counts().rejected(), 1U);
  ASSERT_TRUE(hub_sends(*node, "down"));
  node_receives(*node);
  hub_endpoint_.inject(node->endpoint.local_address(), node->endpoint.arrived().back().bytes);
  EXPECT_TRUE(hub_receives().empty());
  EXPECT_EQ(hub_->seal_counts().rejected(), 1U);
}

TEST_F(SealedHubTest, ASessionIsGoodForItsAddressOnly) {
  const auto node = make_node(2);
  join(*node);
  node_sends(*node, "mine");
  Bytes datagram;
  {
    std::array<std::byte, kMaxDatagramBytes> into;
    hub_receives();
    node_sends(*node, "fresh");
    const Received received = hub_endpoint_.receive(into, 0);
    datagram.assign(into.begin(), into.begin() + static_cast<std::ptrdiff_t>(received.bytes));
  }
  hub_endpoint_.inject(memory_address(66, 6), datagram);
  EXPECT_TRUE(hub_receives().empty());
  EXPECT_EQ(hub_->seal_counts().unknown_session, 1U);
  hub_endpoint_.inject(node->endpoint.local_address(), datagram);
  EXPECT_EQ(hub_receives().count("fresh"), 1U);
}

TEST_F(SealedHubTest, EveryTruncatedAndEveryFlippedDatagramIsRejectedAndCounted) {
  const auto node = make_node(2);
  join(*node);
  node_sends(*node, "some words");
  std::array<std::byte, kMaxDatagramBytes> into;
  const Received received = hub_endpoint_.receive(into, 0);
  const Bytes sealed(into.begin(), into.begin() + static_cast<std::ptrdiff_t>(received.bytes));
  const auto expect_rejected = [&](const Bytes& bytes) {
    const std::uint64_t before = hub_->seal_counts().rejected();
    hub_endpoint_.inject(received.from, bytes);
    ASSERT_TRUE(hub_receives().empty());
    ASSERT_EQ(hub_->seal_counts().rejected(), before + 1);
  };
  const std::size_t sent = hub_endpoint_.sent();
  for (std::size_t size = 1; size < sealed.size(); ++size) {
    expect_rejected(Bytes(sealed.begin(), sealed.begin() + static_cast<std::ptrdiff_t>(size)));
  }
  for (std::size_t bit = 0; bit < 8 * sealed.size(); ++bit) {
    Bytes flipped = sealed;
    flipped[bit / 8] ^= static_cast<std::byte>(1U << (bit % 8));
    expect_rejected(flipped);
  }
  EXPECT_EQ(hub_endpoint_.sent(), sent) << "an unknown peer got a reply";
  hub_endpoint_.inject(received.from, sealed);
  EXPECT_EQ(hub_receives().count("some words"), 1U);
}

TEST_F(SealedHubTest, ARestartedHubIsFoundAgain) {
  const auto one = make_node(2);
  const auto two = make_node(3);
  run_for({one.get(), two.get()}, 500);
  start_hub();
  run_for({one.get(), two.get()}, 350);
  replies_ = 0;
  run_for({one.get(), two.get()}, 200);
  EXPECT_EQ(replies_, 4);
  EXPECT_EQ(hub_->seal_counts().handshakes, 2U);
}

TEST_F(SealedHubTest, AHubThatWasOnlySlowHasLostNothing) {
  const auto node = make_node(2);
  run_for({node.get()}, 10);
  const std::uint64_t handshakes = hub_->seal_counts().handshakes;
  // 150 ms without a datagram from the hub, shorter than its timeout: no new request.
  for (int i = 0; i < 150; ++i) {
    clock_.advance_ns(kMs);
    node_receives(*node);
  }
  EXPECT_TRUE(hub_sends(*node, "here again"));
  EXPECT_EQ(node_receives(*node).size(), 1U);
  // 400 ms: it requests a new session, and meanwhile the old session still works in both directions.
  for (int i = 0; i < 400; ++i) {
    clock_.advance_ns(kMs);
    node_receives(*node);
  }
  EXPECT_TRUE(hub_sends(*node, "old keys"));
  node_sends(*node, "old keys too");
  EXPECT_EQ(node_receives(*node), std::vector<std::string>{"old keys"});
  EXPECT_GE(hub_receives().count("old keys too"), 1U);
  run_for({node.get()}, 300);
  EXPECT_EQ(hub_->seal_counts().handshakes, handshakes + 1);
}

TEST_F(SealedHubTest, ANodeThatWasBusyForLongRequestsNothing) {
  const auto node = make_node(2);
  join(*node);
  for (int turn = 0; turn < 10; ++turn) {
    for (int i = 0; i < 300; ++i) {
      clock_.advance_ns(kMs);
      EXPECT_TRUE(hub_sends(*node, "tick"));
    }
    EXPECT_EQ(node_receives(*node).size(), 300U);
  }
  hub_receives();
  EXPECT_EQ(hub_->seal_counts().handshakes, 1U);
  EXPECT_EQ(hub_endpoint_.arrived().size(), 3U) << "more than the two requests and the datagram of join()";
}

TEST_F(SealedHubTest, UntilTheHubUsesTheNewSessionTheOldOneIsAccepted) {
  const auto node = make_node(2);
  join(*node);
  for (std::uint64_t round = 1; round <= 3; ++round) {
    SCOPED_TRACE(round);
    clock_.advance_ns(SealedClient::kPeerTimeoutNs);
    node_receives(*node);  // requests a session
    hub_receives();        // sends a cookie
    node_sends(*node, "lost on the way");
    node_receives(*node);  // requests with the cookie
    hub_receives();        // agrees on a session
    node_receives(*node);  // has a new session, and sends its datagram in it
    std::array<std::byte, kMaxDatagramBytes> into;
    while (hub_endpoint_.receive(into, 0).bytes != 0) {
    }
    EXPECT_EQ(node->sealed.seal_counts().handshakes, round + 1);
    EXPECT_EQ(hub_->seal_counts().handshakes, round);
    EXPECT_TRUE(hub_sends(*node, "still the old one"));
    EXPECT_EQ(node_receives(*node), std::vector<std::string>{"still the old one"});
    const Bytes old = node->endpoint.arrived().back().bytes;
    // After one datagram in each direction of the new session, the old one is over, except for late datagrams.
    node_sends(*node, "heard");
    EXPECT_EQ(hub_receives().count("heard"), 1U);
    EXPECT_TRUE(hub_sends(*node, "the new one"));
    EXPECT_EQ(node_receives(*node), std::vector<std::string>{"the new one"});
    clock_.advance_ns(SealedClient::kOverlapNs);
    EXPECT_TRUE(hub_sends(*node, "later"));
    EXPECT_EQ(node_receives(*node), std::vector<std::string>{"later"});
    const std::uint64_t unknown = node->sealed.seal_counts().unknown_session;
    node->endpoint.inject(hub_address_, old);
    EXPECT_TRUE(node_receives(*node).empty());
    EXPECT_EQ(node->sealed.seal_counts().unknown_session, unknown + 1);
  }
}

TEST_F(SealedHubTest, ANewSessionSendsNothingOfTheOldOneAgain) {
  const auto node = make_node(2);
  join(*node);
  clock_.advance_ns(SealedClient::kRekeyEveryNs);
  const std::size_t arrived = hub_endpoint_.arrived().size();
  EXPECT_TRUE(run_handshake(*node).empty());
  EXPECT_EQ(node->sealed.seal_counts().handshakes, 2U);
  EXPECT_EQ(hub_endpoint_.arrived().size(), arrived + 2) << "two requests, and no datagram without words";
}

TEST_F(SealedHubTest, ARestartedNodeAtTheSameAddressReplacesItsOwnSession) {
  for (int life = 1; life <= 100; ++life) {
    const auto node = make_node(2);
    join(*node);
    EXPECT_EQ(hub_->seal_counts().handshakes, static_cast<std::uint64_t>(life));
  }
  EXPECT_EQ(hub_->seal_counts().no_slot, 0U);
}

TEST_F(SealedHubTest, LostHandshakesAreRepeated) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    network_.set_impairments({.seed = seed, .loss = 0.3, .duplicate = 0.1, .reorder = 0.1});
    auto node = make_node(2);
    replies_ = 0;
    run_for({node.get()}, 3000);
    EXPECT_GT(replies_, 5);
    EXPECT_EQ(hub_->seal_counts().forged, 0U);
  }
}

TEST_F(SealedHubTest, FullSlotsMakeRoomForNewNodesOnceOldOnesAreGone) {
  std::vector<std::unique_ptr<Node>> vision_nodes;
  for (std::size_t i = 0; i < SealedHub::kRoleSlots[1]; ++i) {  // the slots of vision nodes
    vision_nodes.push_back(make_node(static_cast<std::uint8_t>(10 + i)));
    join(*vision_nodes.back());
  }
  const auto late_node = make_node(200);
  node_sends(*late_node, "any room?");
  EXPECT_TRUE(run_handshake(*late_node).empty());
  EXPECT_GT(hub_->seal_counts().no_slot, 0U);
  for (const auto& node : vision_nodes) EXPECT_TRUE(hub_sends(*node, "you stay"));
  run_for({late_node.get()}, 2500);
  EXPECT_GT(replies_, 0);
}

TEST_F(SealedHubTest, RecordedHandshakesCannotCrowdOutLiveSessions) {
  const auto node = make_node(2);
  join(*node);
  // Requests with valid cookies whose nodes never come back: as many as the holder of a key, or of a recording, can send.
  for (std::uint8_t i = 0; i < 100; ++i) {
    auto lost_node = make_node(static_cast<std::uint8_t>(100 + i));
    node_sends(*lost_node, "boo");
    hub_receives();             // its request gets a cookie
    node_receives(*lost_node);  // requests with the cookie
    lost_node->sealed.send(hub_address_, to_bytes("never mind"));
    std::array<std::byte, kMaxDatagramBytes> into;
    EXPECT_EQ(hub_->receive(into, 0).bytes, 0U);
    clock_.advance_ns(5 * kMs);
  }
  EXPECT_TRUE(hub_sends(*node, "you stay"));
  EXPECT_EQ(node_receives(*node), std::vector<std::string>{"you stay"});
  const auto late_node = make_node(3);
  join(*late_node);
}

TEST_F(SealedHubTest, AFloodIsBoundedAndBlocksNoPoll) {
  const auto node = make_node(2);
  join(*node);
  std::mt19937_64 random(7);
  for (int i = 0; i < 1000; ++i) {
    Bytes junk(1 + random() % 300);
    for (std::byte& byte : junk) byte = static_cast<std::byte>(random());
    hub_endpoint_.inject(memory_address(66, 6), junk);
  }
  std::array<std::byte, kMaxDatagramBytes> into;
  EXPECT_EQ(hub_->receive(into, 0).bytes, 0U);
  EXPECT_LT(hub_->seal_counts().rejected(), 100U);
  node_sends(*node, "through it all");
  EXPECT_GT(hub_->receive(into, clock_.now_ns() + 5 * kMs).bytes, 0U);
  EXPECT_EQ(hub_->seal_counts().rejected(), 1000U);
}

// Endpoints that use no heap, so that only the heap use of sealing counts.
class LoopEndpoint final : public Endpoint {
 public:
  explicit LoopEndpoint(const Address& at) : at_(at) {}
  void connect(LoopEndpoint& other) { other_ = &other; }

  bool send(const Address&, std::span<const std::byte> datagram) noexcept override {
    if (other_->count_ == other_->queue_.size()) return false;
    auto& slot = other_->queue_[other_->count_++];
    std::copy(datagram.begin(), datagram.end(), slot.bytes.begin());
    slot.size = datagram.size();
    return true;
  }
  Received receive(std::span<std::byte> into, std::int64_t) noexcept override {
    if (count_ == 0) return {};
    const auto& slot = queue_[0];
    std::copy_n(slot.bytes.begin(), slot.size, into.begin());
    const Received received{.bytes = slot.size, .from = other_->at_};
    std::move(queue_.begin() + 1, queue_.begin() + static_cast<std::ptrdiff_t>(count_), queue_.begin());
    --count_;
    return received;
  }
  Address local_address() const override { return at_; }

 private:
  struct Slot {
    std::array<std::byte, kMaxDatagramBytes> bytes = {};
    std::size_t size = 0;
  };
  Address at_;
  LoopEndpoint* other_ = nullptr;
  std::array<Slot, 8> queue_ = {};
  std::size_t count_ = 0;
};

class SealedHubHeapTest : public testing::TestWithParam<AgreementWorker::Where> {};
INSTANTIATE_TEST_SUITE_P(Each, SealedHubHeapTest, testing::Values(AgreementWorker::Where::caller, AgreementWorker::Where::own_thread));

TEST_P(SealedHubHeapTest, NeitherSideUsesTheHeapOnceBuilt) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  SimulatedClock clock;
  LoopEndpoint hub_end(memory_address(1, 4950));
  LoopEndpoint node_end(memory_address(2, 9));
  hub_end.connect(node_end);
  node_end.connect(hub_end);
  SealedHub hub(hub_end, clock, key_of(1), GetParam());
  SealedClient node(node_end, clock, RoleKey(key_of(1), KeyRole::vision), hub_end.local_address(), {.worker = GetParam()});
  const std::array<std::byte, 120> payload = {};
  std::array<std::byte, kMaxDatagramBytes> into;
  int arrived = 0;
  const AllocationGuard guard;
  // Agrees on one more session: the first, one after a timeout, then one after the time of a rekeying. The clock advances rarely meanwhile.
  const auto agree_on = [&](std::uint64_t handshakes) {
    for (int turn = 0; turn < 200'000 && hub.seal_counts().handshakes < handshakes; ++turn) {
      node.send(hub_end.local_address(), payload);
      while (hub.receive(into, 0).bytes != 0) ++arrived;
      while (node.receive(into, 0).bytes != 0) ++arrived;
      std::this_thread::yield();
      if (turn % 1000 == 999) clock.advance_ns(kMs);
    }
    EXPECT_EQ(hub.seal_counts().handshakes, handshakes);
  };
  std::uint64_t handshakes = 0;
  for (const std::int64_t pause_ns : {kMs, kNanosecondsPerSecond, SealedClient::kRekeyEveryNs}) {
    clock.advance_ns(pause_ns);
    node.receive(into, 0);
    agree_on(++handshakes);
    for (int i = 0; i < 300; ++i) {
      clock.advance_ns(kMs);
      node.send(hub_end.local_address(), payload);
      while (hub.receive(into, 0).bytes != 0) ++arrived;
      hub.send(node_end.local_address(), payload);
      while (node.receive(into, 0).bytes != 0) ++arrived;
    }
  }
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_GT(arrived, 1700);
}

}  // namespace
}  // namespace hapton::sealed_hub
