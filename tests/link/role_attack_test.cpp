// What the holder of one role's key can do to the other nodes, through the complete link code of the hub. The attacker sees every byte on
// the wire, and may send from any address.
#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <vector>

#include "link/hub_client.h"
#include "link/hub_peers.h"
#include "link/memory_endpoint.h"
#include "link/sealed_client.h"
#include "link/sealed_hub.h"
#include "tests/link/tapped_endpoint.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

using Bytes = std::vector<std::byte>;

constexpr double kTrueForceN = 1.0;
constexpr double kFalseForceN = 3.0;

struct Member {
  Member(MemoryNetwork& network, const Clock& clock, const RoleKey& key, NodeRole role, std::uint8_t host, const Address& hub)
      : endpoint(*network.open(memory_address(host, 9))),
        sealed(endpoint, clock, key, hub, {.host = host}),
        client(sealed, clock, role, hub) {}

  TappedEndpoint endpoint;
  SealedClient sealed;
  HubClient client;
};

class RoleAttack : public testing::Test {
 protected:
  RoleAttack() {
    EXPECT_TRUE(seal::start_crypto());
    sealed_.emplace(hub_endpoint_, clock_, master_);
    peers_.emplace(*sealed_, clock_, 7, 1000.0);
    haptics_ = make_member(KeyRole::haptics, NodeRole::haptics, 2);
  }

  std::unique_ptr<Member> make_member(KeyRole key_role, NodeRole role, std::uint8_t host) {
    return std::make_unique<Member>(network_, clock_, RoleKey(master_, key_role), role, host, hub_address_);
  }

  // A millisecond at a time: the hub sends a state, the haptics node replies, then the attacker acts.
  template <class Turn>
  void run(int ms, Turn&& attacker) {
    for (int i = 0; i < ms; ++i) {
      clock_.advance_ns(kMs);
      peers_->send_to_role(NodeRole::haptics, DeviceState{.sample = ++sample_});
      turn(*haptics_);
      attacker();
      turn_hub();
    }
  }

  void turn(Member& member) {
    Datagram datagram;
    while (member.client.receive(datagram, 0)) {
      const auto* state = std::get_if<DeviceState>(&datagram.message);
      if (state != nullptr) member.client.send(ForceCommand{.echo_sample = state->sample, .force_n = Vec3(kTrueForceN, 0, 0)});
    }
  }

  void turn_hub() {
    Datagram datagram;
    std::uint64_t before = 0;
    do {
      before = peers_->counts().received;
      const PeerEvent event = peers_->receive(datagram, 0);
      const auto* force = std::get_if<ForceCommand>(&datagram.message);
      if (event.kind != PeerEvent::Kind::message || force == nullptr) continue;
      (force->force_n.x() == kTrueForceN ? true_forces_ : false_forces_) += 1;
    } while (peers_->counts().received != before);
  }

  SimulatedClock clock_{1000 * kNanosecondsPerSecond};
  MemoryNetwork network_{clock_};
  Address hub_address_ = memory_address(1, 4950);
  TappedEndpoint hub_endpoint_{*network_.open(hub_address_)};
  LinkKey master_ = LinkKey::make_random();
  std::optional<SealedHub> sealed_;
  std::optional<HubPeers> peers_;
  std::unique_ptr<Member> haptics_;
  std::uint64_t sample_ = 0;
  int true_forces_ = 0;
  int false_forces_ = 0;
};

// An attack that once got 3,399 of 3,399 forces accepted: listen to the handshake, derive the session's keys, seal forces with them.
TEST_F(RoleAttack, ForcesSealedWithKeysDerivedFromAVisionKeyAreRejected) {
  run(300, [] {});
  ASSERT_GT(true_forces_, 250);
  // For each request on the wire, the most that the attacker can do with it and the vision key: pose as the hub, and reply to it with a
  // handshake of the attacker's own.
  const RoleKey vision(master_, KeyRole::vision);
  Codec codec;
  int attempts = 0;
  const auto connections = [&] {
    std::vector<std::uint32_t> numbers;
    for (const auto& arrived : hub_endpoint_.arrived()) {
      if (classify_sealed(arrived.bytes).kind != seal::Kind::data) continue;
      numbers.push_back(seal::load<std::uint32_t>(seal::bytes_of(std::span(arrived.bytes)) + seal::kConnectionAt));
    }
    return numbers;
  }();
  ASSERT_FALSE(connections.empty());
  const std::vector<TappedEndpoint::ArrivedDatagram> recorded = hub_endpoint_.arrived();
  const SealCounts before = sealed_->seal_counts();
  for (const auto& arrived : recorded) {
    if (classify_sealed(arrived.bytes).kind != seal::Kind::request) continue;
    const std::uint8_t* const request = seal::bytes_of(std::span(arrived.bytes));
    AgreementTask task;
    task.kind = AgreementTask::Kind::reply_to_request;
    task.connection = connections.back();
    task.psk = seal::derive_psk(vision);
    std::copy_n(request, seal::kPrologueBytes, task.prologue.begin());
    std::copy_n(request + seal::kFirstAt, seal::kFirstBytes, task.first.begin());
    run_agreement(task);
    EXPECT_FALSE(task.is_valid);
    // The keys in the state after the failed handshake are the best guess that the attacker has.
    const noise::TransportKeys guess = task.state.split();
    seal::ChannelKeys keys;
    keys.client_to_hub = guess.initiator_to_responder;
    keys.hub_to_client = guess.responder_to_initiator;
    SealedChannel channel(keys, connections.back(), SealedChannel::Side::client);
    for (std::uint64_t sequence = 1000; sequence < 1100; ++sequence, ++attempts) {
      Bytes plain(kMaxDatagramBytes);
      plain.resize(codec.encode({{7, 1, sequence, clock_.now_ns()}, ForceCommand{.force_n = Vec3(kFalseForceN, 0, 0)}}, plain));
      Bytes sealed(kMaxDatagramBytes);
      for (int skip = 0; skip < 50; ++skip) channel.seal(plain, sealed);  // passes the counters that the hub has seen
      sealed.resize(channel.seal(plain, sealed));
      hub_endpoint_.inject(arrived.from, sealed);
      turn_hub();
    }
  }
  EXPECT_GE(attempts, 200);
  EXPECT_EQ(false_forces_, 0);
  EXPECT_EQ(sealed_->seal_counts().forged - before.forged + sealed_->seal_counts().replayed - before.replayed,
            static_cast<std::uint64_t>(attempts));
  const int true_forces_before = true_forces_;
  run(100, [] {});
  EXPECT_GE(true_forces_, true_forces_before + 99);
}

TEST_F(RoleAttack, AVisionOrToolKeyJoinsAsNoHapticsNodeAndSendsNoForce) {
  for (const KeyRole key_role : {KeyRole::vision, KeyRole::tool, KeyRole::operator_role}) {
    const std::uint8_t host = static_cast<std::uint8_t>(10 + static_cast<int>(key_role));
    const std::uint64_t violations = peers_->counts().role_violations;
    const auto intruder = make_member(key_role, NodeRole::haptics, host);
    run(300, [&] {
      turn(*intruder);
      intruder->client.send(ForceCommand{.echo_sample = sample_, .force_n = Vec3(kFalseForceN, 0, 0)});
    });
    EXPECT_NE(intruder->client.state(), JoinState::joined);
    EXPECT_GT(peers_->counts().role_violations, violations);
    // Joined in the role of its key, it still sends no force.
    const std::uint64_t wrong_role = peers_->counts().wrong_role;
    const NodeRole own = key_role == KeyRole::vision ? NodeRole::vision : NodeRole::tool;
    const auto member = make_member(key_role, own, static_cast<std::uint8_t>(host + 100));
    run(300, [&] {
      turn(*member);
      member->client.send(ForceCommand{.echo_sample = sample_, .force_n = Vec3(kFalseForceN, 0, 0)});
    });
    EXPECT_EQ(member->client.state(), JoinState::joined);
    EXPECT_GT(peers_->counts().wrong_role, wrong_role);
  }
  EXPECT_EQ(false_forces_, 0);
  EXPECT_GT(true_forces_, 1700);
}

TEST_F(RoleAttack, AnotherSystemsHapticsKeyIsAsGoodAsNone) {
  run(100, [] {});
  Member unknown(network_, clock_, RoleKey(LinkKey::make_random(), KeyRole::haptics), NodeRole::haptics, 66, hub_address_);
  run(300, [&] { turn(unknown); });
  EXPECT_EQ(unknown.client.state(), JoinState::joining);
  EXPECT_EQ(unknown.sealed.seal_counts().opened, 0U);
  EXPECT_GT(sealed_->seal_counts().wrong_key, 0U);
}

}  // namespace
}  // namespace hapton
