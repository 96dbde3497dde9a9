#include "link/hub_client.h"

#include <gtest/gtest.h>

#include <array>
#include <optional>

#include "link/hub_peers.h"
#include "link/memory_endpoint.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

class HubClientTest : public testing::Test {
 protected:
  void start_hub(std::uint64_t session) { hub_.emplace(*hub_endpoint_, clock_, session, 1000.0); }

  // Ends the hub without a Bye, as a crash does.
  void crash_hub() {
    network_.set_impairments({.loss = 1.0});
    hub_.reset();
    network_.set_impairments(impairments_);
  }

  // Runs both sides for duration_ms, a millisecond at a time: the hub sends `states_per_ms` states, the client drains them.
  void run(std::int64_t duration_ms, int states_per_ms = 0) {
    for (std::int64_t i = 0; i < duration_ms; ++i) {
      clock_.advance_ns(kMs);
      if (hub_) {
        turn_hub(states_per_ms);
      }
      Datagram datagram;
      while (client_->receive(datagram, 0)) {
        ++received_states_;
        last_sample_ = std::get<DeviceState>(datagram.message).sample;
      }
    }
  }

  // The hub receives all that has come, and sends this many states.
  void turn_hub(int states) {
    Datagram datagram;
    std::uint64_t before = 0;
    do {
      before = hub_->counts().received;
      hub_messages_ += hub_->receive(datagram, 0).kind == PeerEvent::Kind::message ? 1 : 0;
    } while (hub_->counts().received != before);
    for (int i = 0; i < states; ++i) {
      hub_->send_to_role(NodeRole::haptics, DeviceState{.sample = ++sample_});
    }
  }

  void start_client(NodeRole role = NodeRole::haptics) { client_.emplace(*client_endpoint_, clock_, role, hub_endpoint_->local_address()); }

  Impairments impairments_;
  SimulatedClock clock_;
  MemoryNetwork network_{clock_};
  std::unique_ptr<Endpoint> hub_endpoint_ = *network_.open(memory_address(1, 4950));
  std::unique_ptr<Endpoint> client_endpoint_ = *network_.open(memory_address(2, 0));
  std::optional<HubPeers> hub_;
  std::optional<HubClient> client_;
  std::uint64_t sample_ = 0;
  std::uint64_t last_sample_ = 0;
  int received_states_ = 0;
  int hub_messages_ = 0;
};

TEST_F(HubClientTest, JoinsAndExchangesMessages) {
  start_hub(1);
  start_client();
  EXPECT_EQ(client_->state(), JoinState::joining);
  EXPECT_FALSE(client_->send(ForceCommand{}));
  run(3, 1);
  EXPECT_EQ(client_->state(), JoinState::joined);
  EXPECT_EQ(client_->servo_rate_hz(), 1000.0);
  EXPECT_EQ(client_->session(), 1U);
  EXPECT_GE(received_states_, 2);
  EXPECT_TRUE(client_->send(ForceCommand{.echo_sample = 1}));
  run(1);
  EXPECT_EQ(hub_messages_, 1);
  EXPECT_EQ(client_->counts().joins, 1U);
}

TEST_F(HubClientTest, WhatItCannotReadIsCountedAndPassedOver) {
  start_hub(1);
  start_client();
  run(3, 1);
  const Address client = client_endpoint_->local_address();
  const std::array<std::byte, 2> of_another_version = {std::byte{8}, std::byte{0x7A}};
  const std::array<std::byte, 2> damaged = {std::byte{0xFF}, std::byte{0}};
  hub_endpoint_->send(client, of_another_version);
  hub_endpoint_->send(client, damaged);
  const int before = received_states_;
  run(1, 1);
  EXPECT_EQ(received_states_, before + 1);
  EXPECT_EQ(client_->counts().undecodable, 2U);
  EXPECT_EQ(client_->counts().wrong_version, 1U);
}

// A caller that does not wait must not be held up by useless datagrams: one call of receive() skips 64 of them at most.
TEST_F(HubClientTest, AFloodOfWhatItCannotReadHoldsNobodyUp) {
  start_hub(1);
  start_client();
  run(3, 1);
  const std::array<std::byte, 2> damaged = {std::byte{0xFF}, std::byte{0}};
  Datagram datagram;
  for (const int flood : {63, 64}) {
    for (int n = 0; n < flood; ++n) hub_endpoint_->send(client_endpoint_->local_address(), damaged);
    turn_hub(1);
    EXPECT_EQ(client_->receive(datagram, 0), flood == 63);
    EXPECT_EQ(client_->receive(datagram, 0), flood == 64);
  }
}

TEST_F(HubClientTest, KeepsSayingHelloTenTimesASecond) {
  start_hub(1);
  start_client(NodeRole::vision);
  run(5000);
  EXPECT_EQ(client_->state(), JoinState::joined);
  EXPECT_NEAR(static_cast<double>(client_->counts().sent), 50.0, 1.0);
  EXPECT_EQ(hub_->counts().timeouts, 0U);
}

TEST_F(HubClientTest, WaitsForAHubThatStartsLater) {
  start_client();
  run(700);
  EXPECT_EQ(client_->state(), JoinState::joining);
  start_hub(1);
  run(101);
  EXPECT_EQ(client_->state(), JoinState::joined);
}

TEST_F(HubClientTest, WaitingItselfSaysHello) {
  start_client();
  Datagram datagram;
  EXPECT_FALSE(client_->receive(datagram, clock_.now_ns() + 1000 * kMs));
  EXPECT_NEAR(static_cast<double>(client_->counts().sent), 10.0, 1.0);
}

TEST_F(HubClientTest, NoticesASilentHub) {
  start_hub(1);
  start_client();
  run(10);
  crash_hub();
  run(300);
  EXPECT_EQ(client_->state(), JoinState::joined);
  run(300);
  EXPECT_EQ(client_->state(), JoinState::joining);
}

TEST_F(HubClientTest, JoinsARestartedHubByItself) {
  start_hub(1);
  start_client();
  run(10, 1);
  crash_hub();
  run(20);
  start_hub(2);
  sample_ = 0;
  received_states_ = 0;
  run(110, 1);
  EXPECT_EQ(client_->state(), JoinState::joined);
  EXPECT_EQ(client_->session(), 2U);
  EXPECT_GT(received_states_, 0);
  EXPECT_EQ(client_->counts().joins, 2U);
  EXPECT_EQ(client_->sequence_counts().restarts, 1U);
}

// The hub no longer knows its sequence numbers for this node, because another node has had the slot.
TEST_F(HubClientTest, AReturningNodeReceivesFromAHubThatCountsFromOneAgain) {
  start_hub(1);
  start_client();
  run(3000, 1);
  const auto other_endpoint = *network_.open(memory_address(3, 0));
  std::optional<HubClient> other(std::in_place, *other_endpoint, clock_, NodeRole::haptics, hub_endpoint_->local_address());
  for (int ms = 0; ms < 700; ++ms) {
    clock_.advance_ns(kMs);
    turn_hub(0);
    Datagram datagram;
    other->receive(datagram, 0);
  }
  ASSERT_EQ(other->state(), JoinState::joined);
  other.reset();
  run(150);
  ASSERT_EQ(client_->state(), JoinState::joined);
  received_states_ = 0;
  run(100, 1);
  EXPECT_GE(received_states_, 99);
}

TEST_F(HubClientTest, AHubsByeIsReceived) {
  start_hub(1);
  start_client();
  run(10);
  EXPECT_FALSE(client_->has_hub_left());
  hub_.reset();
  run(1);
  EXPECT_EQ(client_->state(), JoinState::joining);
  EXPECT_TRUE(client_->has_hub_left());
  start_hub(2);
  run(110, 1);
  ASSERT_EQ(client_->state(), JoinState::joined);
  EXPECT_FALSE(client_->has_hub_left());
}

TEST_F(HubClientTest, AHubThatCrashesHasNotLeft) {
  start_hub(1);
  start_client();
  run(10, 1);
  crash_hub();
  run(1200);
  EXPECT_EQ(client_->state(), JoinState::joining);
  EXPECT_FALSE(client_->has_hub_left());
}

TEST_F(HubClientTest, DropsDatagramsOfAnotherSession) {
  start_hub(1);
  start_client();
  run(10, 1);
  crash_hub();
  start_hub(2);
  run(110);
  ASSERT_EQ(client_->session(), 2U);
  // Late datagrams of the earlier hub: a state, and a Welcome that would take the client back to the earlier session.
  received_states_ = 0;
  Codec codec;
  std::array<std::byte, kMaxDatagramBytes> bytes;
  for (const Message& message : {Message(DeviceState{}), Message(Welcome{true, 1000.0})}) {
    const std::size_t size = codec.encode({{1, 5, 1000, 0}, message}, bytes);
    hub_endpoint_->send(client_endpoint_->local_address(), std::span(bytes).first(size));
  }
  run(1);
  EXPECT_EQ(received_states_, 0);
  EXPECT_EQ(client_->session(), 2U);
  EXPECT_EQ(client_->counts().other_session, 2U);
}

// While another node held the slot, the hub rejected this one. The network delivers that rejection after the later Welcome.
TEST_F(HubClientTest, ARejectionThatAWelcomeHasOvertakenIsDropped) {
  start_hub(1);
  start_client();
  run(200);
  ASSERT_EQ(client_->state(), JoinState::joined);
  Codec codec;
  std::array<std::byte, kMaxDatagramBytes> bytes;
  const auto reject_at = [&](std::int64_t sent_ns) {
    const std::size_t size = codec.encode({{1, 5, 1000, sent_ns}, Welcome{false, 1000.0}}, bytes);
    hub_endpoint_->send(client_endpoint_->local_address(), std::span(bytes).first(size));
    Datagram datagram;
    client_->receive(datagram, 0);
    return client_->state();
  };
  EXPECT_EQ(reject_at(1), JoinState::joined);
  EXPECT_EQ(reject_at(clock_.now_ns()), JoinState::rejected);
}

TEST_F(HubClientTest, ListensToTheHubsAddressOnly) {
  start_hub(1);
  start_client();
  run(10);
  const auto unknown = *network_.open(memory_address(66, 6));
  Codec codec;
  std::array<std::byte, kMaxDatagramBytes> bytes;
  for (const Message& message : {Message(DeviceState{}), Message(Welcome{true, 1000.0}), Message(Bye{})}) {
    const std::size_t size = codec.encode({{1, 5, 1000, 0}, message}, bytes);
    unknown->send(client_endpoint_->local_address(), std::span(bytes).first(size));
  }
  run(1);
  EXPECT_EQ(received_states_, 0);
  EXPECT_EQ(client_->state(), JoinState::joined);
  EXPECT_EQ(client_->counts().foreign, 3U);
}

TEST_F(HubClientTest, AFloodOfRubbishCannotBlockAPoll) {
  start_hub(1);
  start_client();
  run(10);
  const auto unknown = *network_.open(memory_address(66, 6));
  const std::array<std::byte, 4> rubbish = {};
  for (int i = 0; i < 1000; ++i) {
    unknown->send(client_endpoint_->local_address(), rubbish);
  }
  Datagram datagram;
  EXPECT_FALSE(client_->receive(datagram, 0));
  EXPECT_LT(client_->counts().foreign, 100U);
  const std::int64_t start_ns = clock_.now_ns();
  EXPECT_FALSE(client_->receive(datagram, start_ns + 5 * kMs));
  EXPECT_EQ(client_->counts().foreign, 1000U);
  EXPECT_EQ(clock_.now_ns(), start_ns + 5 * kMs);
}

TEST_F(HubClientTest, ASecondHapticsNodeIsRejectedAndTakesOverWhenTheFirstDies) {
  start_hub(1);
  start_client();
  run(5);
  const auto endpoint = *network_.open(memory_address(3, 0));
  HubClient second(*endpoint, clock_, NodeRole::haptics, hub_endpoint_->local_address());
  Datagram datagram;
  for (int i = 0; i < 300; ++i) {
    client_->send(ForceCommand{});
    run(1, 1);
    EXPECT_FALSE(second.receive(datagram, 0));
  }
  EXPECT_EQ(second.state(), JoinState::rejected);
  EXPECT_EQ(client_->state(), JoinState::joined);
  EXPECT_FALSE(second.send(ForceCommand{}));
  // The first node dies without a Bye: after 50 ms of timeout and one Hello period the second one has its slot.
  int served_at_ms = -1;
  for (int i = 0; i < 300 && served_at_ms < 0; ++i) {
    clock_.advance_ns(kMs);
    turn_hub(1);
    served_at_ms = second.receive(datagram, 0) ? i : -1;
  }
  EXPECT_GE(served_at_ms, 0);
  EXPECT_LE(served_at_ms, 152);
  EXPECT_EQ(second.state(), JoinState::joined);
}

// A partition of the network: the hub drops the node, which returns in the same session. New datagrams must not count as old.
TEST_F(HubClientTest, ReceivesAtOnceAfterTheHubDroppedIt) {
  start_hub(1);
  start_client();
  run(1500, 1);
  ASSERT_EQ(client_->state(), JoinState::joined);
  impairments_.loss = 1.0;
  network_.set_impairments(impairments_);
  run(1500, 1);
  EXPECT_EQ(client_->state(), JoinState::joining);
  impairments_.loss = 0.0;
  network_.set_impairments(impairments_);
  const int before = received_states_;
  run(300, 1);
  EXPECT_EQ(client_->state(), JoinState::joined);
  EXPECT_GT(received_states_ - before, 150);
}

TEST_F(HubClientTest, SaysByeWhenItGoes) {
  start_hub(1);
  start_client();
  run(5);
  ASSERT_TRUE(hub_->has_haptics());
  client_.reset();
  Datagram datagram;
  EXPECT_EQ(hub_->receive(datagram, 0).kind, PeerEvent::Kind::left);
  EXPECT_FALSE(hub_->has_haptics());
}

TEST_F(HubClientTest, LeavesOnRequestAndOnlyOnce) {
  start_hub(1);
  start_client();
  run(5);
  ASSERT_TRUE(hub_->has_haptics());
  client_->leave();
  EXPECT_EQ(client_->state(), JoinState::joining);
  Datagram datagram;
  EXPECT_EQ(hub_->receive(datagram, 0).kind, PeerEvent::Kind::left);
  EXPECT_FALSE(hub_->has_haptics());
  client_.reset();
  EXPECT_EQ(hub_->receive(datagram, 0).kind, PeerEvent::Kind::none);
}

TEST_F(HubClientTest, StaysJoinedAndCountsOnABadNetwork) {
  impairments_ = {.seed = 11, .loss = 0.05, .duplicate = 0.02, .reorder = 0.05, .jitter_ns = kMs / 2};
  network_.set_impairments(impairments_);
  start_hub(1);
  start_client();
  run(5000, 1);
  EXPECT_EQ(client_->state(), JoinState::joined);
  const SequenceCounts& counts = client_->sequence_counts();
  const double sent = static_cast<double>(hub_->peer(HubPeers::kHapticsSlot).sent);
  EXPECT_NEAR(static_cast<double>(counts.lost), 0.05 * sent, 0.01 * sent);
  EXPECT_NEAR(static_cast<double>(counts.duplicate), 0.02 * sent, 0.01 * sent);
  EXPECT_GT(counts.reordered, 100U);
  EXPECT_EQ(static_cast<std::uint64_t>(received_states_), client_->counts().received);
  EXPECT_GE(last_sample_ + 10, sample_);
}

// An endpoint that always receives the same datagram and uses no heap, so that only the client's own heap use counts.
class FixedDatagramEndpoint final : public Endpoint {
 public:
  bool send(const Address&, std::span<const std::byte>) noexcept override { return true; }
  Received receive(std::span<std::byte> into, std::int64_t) noexcept override {
    std::copy(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size), into.begin());
    return {.bytes = size, .from = memory_address(1, 4950)};
  }
  Address local_address() const override { return memory_address(2, 1); }

  std::array<std::byte, kMaxDatagramBytes> bytes = {};
  std::size_t size = 0;
};

TEST(HubClientHeapTest, UsesNoHeapOnceBuilt) {
  if (!AllocationGuard::is_available()) {
    GTEST_SKIP() << "heap use cannot be counted in this build";
  }
  SimulatedClock clock;
  FixedDatagramEndpoint endpoint;
  HubClient client(endpoint, clock, NodeRole::haptics, memory_address(1, 4950));
  Codec codec;
  Datagram datagram;
  const AllocationGuard guard;
  endpoint.size = codec.encode({{1, 2, 1, 0}, Welcome{true, 1000.0}}, endpoint.bytes);
  client.receive(datagram, 0);
  ASSERT_EQ(client.state(), JoinState::joined);
  for (std::uint64_t i = 2; i < 1000; ++i) {
    clock.advance_ns(kMs);
    endpoint.size = codec.encode({{1, 2, i, 0}, DeviceState{.sample = i}}, endpoint.bytes);
    ASSERT_TRUE(client.receive(datagram, 0));
    ASSERT_TRUE(client.send(ForceCommand{.echo_sample = i}));
  }
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace hapton
