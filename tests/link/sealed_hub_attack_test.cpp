// Replayed handshakes, floods, roles and changes of keys at the hub.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "link/key_schedule.h"
#include "link/seal_format.h"
#include "tests/link/sealed_hub_fixture.h"

namespace hapton::sealed_hub {
namespace {

// --- recorded handshakes, and floods of handshakes

TEST_F(SealedHubTest, AReplayedHandshakeGetsNoReplyFromAnyAddressAndIsCounted) {
  const auto node = make_node(2);
  join(*node);
  const auto recorded = hub_endpoint_.arrived();
  const std::size_t sent = hub_endpoint_.sent();
  std::uint64_t replays = 0;
  for (const Address& from : {node->endpoint.local_address(), memory_address(66, 6), memory_address(2, 10)}) {
    for (const auto& arrived : recorded) {
      if (classify_sealed(arrived.bytes).kind != seal::Kind::request) continue;
      for (int times = 0; times < 100; ++times) {
        hub_endpoint_.inject(from, arrived.bytes);
        EXPECT_TRUE(hub_receives().empty());
        ++replays;
      }
    }
  }
  EXPECT_EQ(replays, 600U) << "two requests, each 100 times from three addresses";
  EXPECT_EQ(hub_endpoint_.sent(), sent) << "a replay got a reply";
  EXPECT_EQ(hub_->seal_counts().replayed_handshakes, replays);
}

// A restarted hub has seen no timestamps: for each recorded request that is later than those before, it sends a cookie, no longer than
// the request and within the rate limit, but it never agrees on a session.
TEST_F(SealedHubTest, ARestartedHubGivesARecordingNoMoreThanACookie) {
  const auto node = make_node(2);
  join(*node);
  const auto recorded = hub_endpoint_.arrived();
  start_hub();
  const std::size_t sent = hub_endpoint_.sent();
  for (int times = 0; times < 1000; ++times) {
    for (const auto& arrived : recorded) hub_endpoint_.inject(memory_address(66, 6), arrived.bytes);
    EXPECT_TRUE(hub_receives().empty());
  }
  EXPECT_LE(hub_endpoint_.sent() - sent, 2U);
  EXPECT_EQ(hub_->seal_counts().handshakes, 0U);
}

// Datagrams of a kind that only a hub sends, or with a role that does not exist.
TEST_F(SealedHubTest, WhatNoNodeSendsIsMalformed) {
  const auto node = make_node(2);
  join(*node);
  const auto from_hub = node->endpoint.arrived();
  std::uint64_t malformed = 0;
  for (const auto& arrived : from_hub) {
    if (classify_sealed(arrived.bytes).kind == seal::Kind::data) continue;
    hub_endpoint_.inject(node->endpoint.local_address(), arrived.bytes);
    EXPECT_TRUE(hub_receives().empty());
    EXPECT_EQ(hub_->seal_counts().malformed, ++malformed);
  }
  EXPECT_EQ(malformed, 2U) << "a retry and a reply";
  Bytes request = hub_endpoint_.arrived().front().bytes;
  ASSERT_EQ(classify_sealed(request).kind, seal::Kind::request);
  request[seal::kRoleAt] = std::byte{0x77};
  hub_endpoint_.inject(node->endpoint.local_address(), request);
  EXPECT_TRUE(hub_receives().empty());
  EXPECT_EQ(hub_->seal_counts().malformed, malformed + 1);
}

// The sender can sign with a role's key, but lacks the secrets of this handshake: the handshake ends, and its slot is free again.
TEST_F(SealedHubTest, AHandshakeThatIsSignedAndDoesNotFitEndsWithoutASession) {
  const auto node = make_node(2);
  join(*node);
  Bytes request;
  for (const auto& arrived : hub_endpoint_.arrived()) {
    if (classify_sealed(arrived.bytes).kind == seal::Kind::request) request = arrived.bytes;  // the last one has the cookie
  }
  const seal::Secret key = seal::derive_handshake_key(RoleKey(key_of(1), KeyRole::vision));
  const std::size_t sent = hub_endpoint_.sent();
  for (std::uint64_t times = 1; times <= 30; ++times) {
    clock_.advance_ns(20 * kMs);  // within the rate of handshakes
    std::uint8_t* const bytes = seal::bytes_of(std::span<std::byte>(request));
    seal::store(seal::load<std::int64_t>(bytes + seal::kRequestTimestampAt) + 1, bytes + seal::kRequestTimestampAt);
    const seal::Tag tag = seal::compute_tag(key, {bytes, seal::kRequestTagAt});
    std::copy(tag.begin(), tag.end(), bytes + seal::kRequestTagAt);
    hub_endpoint_.inject(node->endpoint.local_address(), request);
    EXPECT_TRUE(hub_receives().empty());
    ASSERT_EQ(hub_->seal_counts().wrong_key, times);
  }
  EXPECT_EQ(hub_endpoint_.sent(), sent);
  EXPECT_EQ(hub_->seal_counts().handshakes, 1U);
  node_sends(*node, "still here");
  EXPECT_EQ(hub_receives().count("still here"), 1U);
}

TEST_F(SealedHubTest, RetriesAreLimitedAndTheRestIsCounted) {
  // The holder of a key can make any number of valid requests: one address, many ports and hosts.
  for (int i = 0; i < 1000; ++i) {
    ClientHandshake sender(RoleKey(key_of(1), KeyRole::tool), static_cast<std::uint64_t>(i), AgreementWorker::Where::caller);
    sender.begin();
    sender.start_request(1000 + i);
    Bytes request(seal::kRequestBytes);
    sender.poll(request);
    hub_endpoint_.inject(memory_address(66, static_cast<std::uint16_t>(1000 + i)), request);
    EXPECT_TRUE(hub_receives().empty());
  }
  EXPECT_EQ(hub_->seal_counts().retries, static_cast<std::uint64_t>(SealedHub::kHandshakeRates.source_burst));
  EXPECT_EQ(hub_->seal_counts().retries + hub_->seal_counts().too_many_handshakes, 1000U);
  EXPECT_EQ(hub_endpoint_.sent(), hub_->seal_counts().retries);
  // Other nodes are served meanwhile.
  const auto node = make_node(2);
  join(*node);
}

TEST_F(SealedHubTest, AFloodIsNamed) {
  const auto node = make_node(2);
  join(*node);
  const auto recorded = hub_endpoint_.arrived().front().bytes;
  hub_->take_flood(clock_.now_ns());
  for (int i = 0; i < 5000; ++i) hub_endpoint_.inject(memory_address(66, 6), recorded);
  while (hub_->seal_counts().replayed_handshakes < 5000) hub_receives();
  clock_.advance_ns(kNanosecondsPerSecond);
  const auto flood = hub_->take_flood(clock_.now_ns());
  ASSERT_TRUE(flood);
  EXPECT_EQ(flood->rejection, Rejection::replayed_handshake);
  EXPECT_EQ(flood->from, memory_address(66, 6));
  EXPECT_NEAR(flood->per_second, 5000.0, 1.0);
}

TEST_F(SealedHubTest, AFloodOfOverlongDatagramsIsCountedAndNamed) {
  hub_->take_flood(clock_.now_ns());
  hub_endpoint_.inject_oversized(memory_address(66, 6), 740'000);
  clock_.advance_ns(kNanosecondsPerSecond);
  const auto flood = hub_->take_flood(clock_.now_ns());
  ASSERT_TRUE(flood);
  EXPECT_EQ(flood->rejection, Rejection::oversized);
  EXPECT_EQ(flood->from, memory_address(66, 6));
  EXPECT_NEAR(flood->per_second, 740'000.0, 1.0);
  EXPECT_EQ(hub_->seal_counts().oversized, 740'000U);
  EXPECT_EQ(hub_->seal_counts().rejected(), 740'000U);
  clock_.advance_ns(kNanosecondsPerSecond);
  EXPECT_FALSE(hub_->take_flood(clock_.now_ns())) << "it is over";
}

TEST_F(SealedHubTest, AFloodThatAFilterKeepsOutIsNamedWithAllOfIt) {
  hub_->take_flood(clock_.now_ns());
  for (int i = 0; i < 500; ++i) hub_endpoint_.inject(memory_address(66, 6), Bytes(40, std::byte{1}));
  while (hub_->seal_counts().malformed < 500) hub_receives();
  hub_endpoint_.filter(199'500);
  clock_.advance_ns(kNanosecondsPerSecond);
  const auto flood = hub_->take_flood(clock_.now_ns());
  ASSERT_TRUE(flood);
  EXPECT_EQ(flood->rejection, Rejection::malformed);
  EXPECT_NEAR(flood->per_second, 200'000.0, 1e-3);
  EXPECT_TRUE(flood->is_mostly_filtered);
}

// The reply's session number is sealed: the filter must get it, or it drops the node's first data.
TEST_F(SealedHubTest, TheEndpointKnowsWhichSessionToExpectFromEachPeer) {
  const auto node = make_node(2);
  join(*node);
  ASSERT_EQ(hub_endpoint_.expected().size(), 1U);
  const auto& [from, connection] = hub_endpoint_.expected().front();
  const auto& arrived = hub_endpoint_.arrived().back();
  EXPECT_EQ(from, arrived.from);
  ASSERT_EQ(classify_sealed(arrived.bytes).kind, seal::Kind::data);
  EXPECT_EQ(connection, seal::load<std::uint32_t>(seal::bytes_of(std::span<const std::byte>(arrived.bytes)) + seal::kConnectionAt));
}

// --- roles

// A request of a sender that has only a key: it can claim any host.
Bytes make_request(KeyRole role, std::uint64_t host, std::int64_t time_ns) {
  ClientHandshake sender(RoleKey(key_of(1), role), host, AgreementWorker::Where::caller);
  sender.begin();
  sender.start_request(time_ns);
  Bytes request(seal::kRequestBytes);
  sender.poll(request);
  return request;
}

// Addresses can be forged. Without the rates by role, the holder of a tool's key could keep the haptics node from its cookie for ever.
TEST_F(SealedHubTest, AFloodOfOneRolesHandshakesLeavesTheOtherRolesTheirRate) {
  std::unique_ptr<Node> haptics;  // joins when the flood has used up every burst
  std::uint64_t requests = 0;
  for (int ms = 0; ms < 200; ++ms) {
    clock_.advance_ns(kMs);
    for (int i = 0; i < 5; ++i, ++requests) {  // 5,000 a second, each from another host
      hub_endpoint_.inject(memory_address(static_cast<std::uint8_t>(20 + requests % 200), 9), make_request(KeyRole::tool, requests, 1));
    }
    hub_receives();
    if (ms == 100) haptics = make_node(2, key_of(1), KeyRole::haptics);
    if (haptics == nullptr) continue;
    node_sends(*haptics, "hello");
    hub_receives();
    node_receives(*haptics);
  }
  EXPECT_GT(hub_->seal_counts().too_many_handshakes, 500U);
  EXPECT_TRUE(hub_sends(*haptics, "welcome")) << "the haptics node has not joined within 100 ms";
}

// Sessions in which nothing was opened yet have half of a role's slots at most: the next request takes the slot of the oldest one,
// although slots are free.
TEST_F(SealedHubTest, UnusedSessionsHaveHalfOfTheSlotsOfTheirRole) {
  constexpr std::size_t kMax = SealedHub::kRoleSlots[0] / 2;  // half of the slots of haptics nodes
  std::vector<std::unique_ptr<Node>> nodes;
  for (std::size_t i = 0; i <= kMax; ++i) {
    nodes.push_back(make_node(static_cast<std::uint8_t>(10 + i), key_of(1), KeyRole::haptics));
    node_sends(*nodes.back(), "hello");
    hub_receives();                // its request gets a cookie
    node_receives(*nodes.back());  // requests with the cookie
    hub_receives();                // gets a reply
    clock_.advance_ns(5 * kMs);
  }
  for (const auto& node : nodes) node_receives(*node);  // has a session, and sends what waited
  EXPECT_EQ(hub_receives().size(), kMax);
  EXPECT_EQ(hub_->seal_counts().handshakes, kMax);
  EXPECT_EQ(hub_->seal_counts().unknown_session, 1U) << "of the first node";
}

TEST_F(SealedHubTest, SessionsOfOneRoleTakeNoSlotOfAnother) {
  std::vector<std::unique_ptr<Node>> tools;
  for (std::size_t i = 0; i < SealedHub::kSlots; ++i) {
    tools.push_back(make_node(static_cast<std::uint8_t>(10 + i), key_of(1), KeyRole::tool));
    node_sends(*tools.back(), "mine");
    run_handshake(*tools.back());
    for (const auto& node : tools) node->sealed.send(hub_address_, to_bytes("still here"));
    hub_receives();
  }
  EXPECT_EQ(hub_->seal_counts().handshakes, SealedHub::kRoleSlots[2]);
  EXPECT_GT(hub_->seal_counts().no_slot, 0U);
  const auto haptics = make_node(2, key_of(1), KeyRole::haptics);
  join(*haptics);
  const auto again = make_node(3, key_of(1), KeyRole::haptics);
  join(*again);
  const auto vision = make_node(4, key_of(1), KeyRole::vision);
  join(*vision);
}

TEST_F(SealedHubTest, EveryDatagramHandedOutHasTheRoleOfItsKey) {
  const auto haptics = make_node(2, key_of(1), KeyRole::haptics);
  const auto tool = make_node(3, key_of(1), KeyRole::tool);
  std::array<std::byte, kMaxDatagramBytes> into;
  for (const auto& [node, role] : {std::pair(haptics.get(), KeyRole::haptics), std::pair(tool.get(), KeyRole::tool)}) {
    join(*node);
    node_sends(*node, "who am I");
    EXPECT_EQ(hub_->receive(into, 0).role, role);
  }
}

// The holder of the vision key who can forge the haptics node's address does not end the haptics node's session.
TEST_F(SealedHubTest, AnotherRoleTakesNoAddressThatIsInUse) {
  const auto haptics = make_node(2, key_of(1), KeyRole::haptics);
  join(*haptics);
  ClientHandshake intruder(RoleKey(key_of(1), KeyRole::vision), 5, AgreementWorker::Where::caller);
  intruder.begin();
  const Address at = haptics->endpoint.local_address();
  Bytes request(seal::kRequestBytes);
  const auto start_request = [&](std::int64_t time_ns) {
    intruder.start_request(time_ns);
    intruder.poll(request);
    hub_endpoint_.inject(at, request);
    hub_receives();
    node_receives(*haptics);  // takes the datagram off the wire
    return haptics->endpoint.arrived().back().bytes;
  };
  ASSERT_TRUE(intruder.read_retry(start_request(1)));
  const std::uint64_t rejected = hub_->seal_counts().no_slot;
  start_request(2);
  EXPECT_EQ(hub_->seal_counts().no_slot, rejected + 1);
  EXPECT_TRUE(hub_sends(*haptics, "still yours"));
  EXPECT_EQ(node_receives(*haptics), std::vector<std::string>{"still yours"});
}

// --- rekeying

// A node at 1 kHz with a reply to every datagram, over a wire that delays, jitters and reorders: over many changes of keys no datagram and
// no reply is lost, and none comes later than the wire makes it.
TEST_F(SealedHubTest, AtAChangeOfKeysNoDatagramIsLostOrLate) {
  for (const std::int64_t jitter_ns : {std::int64_t{0}, 5 * kMs}) {
    SCOPED_TRACE(jitter_ns);
    start_hub();
    network_.set_impairments({.seed = 5, .reorder = jitter_ns == 0 ? 0.0 : 0.2, .delay_ns = 2 * kMs, .jitter_ns = jitter_ns});
    Node node(network_, clock_, memory_address(static_cast<std::uint8_t>(jitter_ns == 0 ? 20 : 21), 9), hub_address_,
              RoleKey(key_of(1), KeyRole::haptics));
    SealedClient sealed(node.endpoint, clock_, RoleKey(key_of(1), KeyRole::haptics), hub_address_,
                        {.host = 1000 + static_cast<std::uint64_t>(jitter_ns), .rekey_every_ns = 300 * kMs});
    std::array<std::byte, kMaxDatagramBytes> into;
    std::map<int, std::int64_t> sent_ns;
    std::map<int, int> reply_counts;
    std::int64_t longest_round_trip_ns = 0;
    constexpr int kWarmUp = 50;
    constexpr int kTurns = 5000;
    for (int turn = 0; turn < kTurns + 50; ++turn) {
      clock_.advance_ns(kMs);
      if (turn < kTurns) {
        sent_ns[turn] = clock_.now_ns();
        EXPECT_TRUE(sealed.send(hub_address_, to_bytes(std::to_string(turn))));
      }
      for (const auto& [text, from] : hub_receives()) hub_->send(from, to_bytes(text));
      for (Received received = sealed.receive(into, 0); received.bytes != 0; received = sealed.receive(into, 0)) {
        const int turn_of_reply = std::stoi(to_text(std::span(into).first(received.bytes)));
        ++reply_counts[turn_of_reply];
        if (turn_of_reply >= kWarmUp) longest_round_trip_ns = std::max(longest_round_trip_ns, clock_.now_ns() - sent_ns[turn_of_reply]);
      }
    }
    EXPECT_GE(sealed.seal_counts().handshakes, 15U);
    for (int turn = kWarmUp; turn < kTurns; ++turn) ASSERT_EQ(reply_counts[turn], 1) << turn;
    EXPECT_LE(longest_round_trip_ns, 4 * kMs + 2 * jitter_ns + (jitter_ns == 0 ? 0 : 4 * kMs) + 2 * kMs);
    EXPECT_EQ(sealed.seal_counts().rejected(), 0U);
    EXPECT_EQ(hub_->seal_counts().forged + hub_->seal_counts().unknown_session, 0U);
  }
}

TEST_F(SealedHubTest, ASessionIsReplacedAfterSoManyDatagramsToo) {
  Node node(network_, clock_, memory_address(20, 9), hub_address_, RoleKey(key_of(1), KeyRole::haptics));
  SealedClient sealed(node.endpoint, clock_, RoleKey(key_of(1), KeyRole::haptics), hub_address_, {.host = 9, .rekey_after = 100});
  std::array<std::byte, kMaxDatagramBytes> into;
  int arrived = 0;
  for (int turn = 0; turn < 1000; ++turn) {
    clock_.advance_ns(kMs);
    sealed.send(hub_address_, to_bytes("x"));
    for (const auto& [text, from] : hub_receives()) hub_->send(from, to_bytes(text));
    while (sealed.receive(into, 0).bytes != 0) ++arrived;
  }
  EXPECT_GE(sealed.seal_counts().handshakes, 8U);
  EXPECT_GE(arrived, 999);
}

TEST_F(SealedHubTest, TheOldSessionIsOverAfterTheOverlap) {
  const auto node = make_node(2);
  join(*node);
  // A very late datagram: the network holds it while the keys change.
  node_sends(*node, "slow");
  std::array<std::byte, kMaxDatagramBytes> into;
  const Received slow = hub_endpoint_.receive(into, 0);
  const Bytes slow_bytes(into.begin(), into.begin() + static_cast<std::ptrdiff_t>(slow.bytes));
  node_sends(*node, "slower");
  const Received slower = hub_endpoint_.receive(into, 0);
  const Bytes slower_bytes(into.begin(), into.begin() + static_cast<std::ptrdiff_t>(slower.bytes));
  clock_.advance_ns(SealedClient::kRekeyEveryNs);
  node_sends(*node, "wake");
  run_handshake(*node);
  node_sends(*node, "new keys");
  EXPECT_EQ(hub_receives().count("new keys"), 1U);
  EXPECT_EQ(hub_->seal_counts().handshakes, 2U);
  hub_endpoint_.inject(slow.from, slow_bytes);
  EXPECT_EQ(hub_receives().count("slow"), 1U);
  clock_.advance_ns(SealedHub::kOverlapNs);
  hub_endpoint_.inject(slow.from, slower_bytes);
  EXPECT_TRUE(hub_receives().empty());
}

// --- with worker threads, as the nodes run

TEST(SealedThreadsTest, ANodeThatHasAgreedRequestsNothingMore) {
  SteadyClock clock;
  MemoryNetwork network(clock);
  const Address at = memory_address(1, 4950);
  auto hub_end = *network.open(at);
  SealedHub hub(*hub_end, clock, key_of(1), AgreementWorker::Where::own_thread);
  TappedEndpoint node_end(*network.open(memory_address(2, 9)));
  SealedClient node(node_end, clock, RoleKey(key_of(1), KeyRole::haptics), at, {.worker = AgreementWorker::Where::own_thread});
  std::array<std::byte, kMaxDatagramBytes> into;
  const std::int64_t end_ns = clock.now_ns() + 20 * kNanosecondsPerSecond;
  node.send(at, to_bytes("x"));
  while (node.seal_counts().handshakes == 0 && clock.now_ns() < end_ns) {
    hub.receive(into, 0);
    node.receive(into, clock.now_ns() + kMs / 4);
  }
  ASSERT_EQ(node.seal_counts().handshakes, 1U);
  const std::size_t sent = node_end.sent();
  for (int turn = 0; turn < 20; ++turn) node.receive(into, clock.now_ns() + kMs);
  EXPECT_EQ(node_end.sent(), sent);
}

// The worker thread finishes a session at any time, so also within the call that sends.
TEST_F(SealedHubTest, WhatIsSentAsASessionBeginsIsSentOnce) {
  int begun_by_send = 0;
  for (std::uint8_t host = 2; host < 22; ++host) {
    TappedEndpoint end(*network_.open(memory_address(host, 9)));
    SealedClient node(end, clock_, RoleKey(key_of(1), KeyRole::vision), hub_address_,
                      {.host = host, .worker = AgreementWorker::Where::own_thread});
    std::multimap<std::string, Address> arrived;
    std::array<std::byte, kMaxDatagramBytes> into;
    std::size_t hub_sent = hub_endpoint_.sent();
    for (int n = 0; node.seal_counts().handshakes == 0; ++n) {
      EXPECT_TRUE(node.send(hub_address_, to_bytes(std::to_string(n))));
      begun_by_send += node.seal_counts().handshakes == 1 ? 1 : 0;
      arrived.merge(hub_receives());
      if (hub_endpoint_.sent() != std::exchange(hub_sent, hub_endpoint_.sent())) (void)node.receive(into, 0);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));  // the worker finishes here, so the next send takes its result
    }
    arrived.merge(hub_receives());
    EXPECT_EQ(arrived.size(), 1U) << "the newest datagram, once";
    clock_.advance_ns(20 * kMs);  // lets the handshake rates recover
  }
  EXPECT_GT(begun_by_send, 0);
}

TEST(SealedThreadsTest, NodesJoinAndChangeKeysWithoutTheCallerWaiting) {
  SteadyClock clock;
  MemoryNetwork network(clock);
  const Address at = memory_address(1, 4950);
  auto hub_end = *network.open(at);
  SealedHub hub(*hub_end, clock, key_of(1), AgreementWorker::Where::own_thread);
  auto node_end = *network.open(memory_address(2, 9));
  SealedClient node(*node_end, clock, RoleKey(key_of(1), KeyRole::haptics), at,
                    {.worker = AgreementWorker::Where::own_thread, .rekey_every_ns = 20 * kMs});
  std::array<std::byte, kMaxDatagramBytes> into;
  std::uint64_t arrived = 0;
  const std::int64_t end_ns = clock.now_ns() + 20 * kNanosecondsPerSecond;
  while (node.seal_counts().handshakes < 10 && clock.now_ns() < end_ns) {
    node.send(at, to_bytes("x"));
    if (hub.receive(into, clock.now_ns() + kMs).bytes != 0) hub.send(memory_address(2, 9), to_bytes("y"));
    if (node.receive(into, clock.now_ns() + kMs).bytes != 0) ++arrived;
  }
  EXPECT_GE(node.seal_counts().handshakes, 10U);
  EXPECT_GT(arrived, 10U);
  EXPECT_EQ(node.seal_counts().forged + hub.seal_counts().forged, 0U);
}

}  // namespace
}  // namespace hapton::sealed_hub
