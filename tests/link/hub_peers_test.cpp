#include "link/hub_peers.h"

#include <gtest/gtest.h>

#include <random>
#include <set>
#include <variant>
#include <vector>

#include "link/hub_client.h"
#include "tests/link/hub_peers_fixture.h"
#include "tests/support/allocation_guard.h"

namespace hapton::hub_peers {
namespace {

TEST_F(HubPeersTest, WelcomesANodeWithSessionAndRate) {
  RawNode node = raw_node(2, 20);
  send(node, Hello{NodeRole::vision}, 0);
  const PeerEvent joined = take_only_event();
  EXPECT_EQ(joined.kind, Kind::joined);
  EXPECT_EQ(joined.role, NodeRole::vision);
  EXPECT_FALSE(joined.replaced);
  EXPECT_EQ(hub_->peer(joined.peer).address, node.endpoint->local_address());
  const std::vector<Datagram> replies = received_by(node);
  ASSERT_EQ(replies.size(), 1U);
  EXPECT_EQ(replies[0].header.session, kSession);
  EXPECT_EQ(replies[0].header.sequence, 1U);
  const auto& welcome = std::get<Welcome>(replies[0].message);
  EXPECT_TRUE(welcome.accepted);
  EXPECT_EQ(welcome.servo_rate_hz, kRateHz);
}

TEST_F(HubPeersTest, RepliesToEveryHelloAndJoinsOnce) {
  RawNode node = raw_node(2, 20);
  send(node, Hello{NodeRole::vision}, 0);
  send(node, Hello{NodeRole::vision});
  EXPECT_EQ(take_events().size(), 1U);
  EXPECT_EQ(received_by(node).size(), 2U);
  EXPECT_EQ(hub_->count(NodeRole::vision), 1U);
}

TEST_F(HubPeersTest, RejectsASecondHapticsNodeWhileTheFirstLives) {
  RawNode first = raw_node(2, 20);
  RawNode second = raw_node(3, 30);
  send(first, Hello{NodeRole::haptics}, 0);
  EXPECT_EQ(take_only_event().peer, HubPeers::kHapticsSlot);
  clock_.advance_ns(HubPeers::kHapticsTimeoutNs);
  send(second, Hello{NodeRole::haptics}, 0);
  EXPECT_EQ(take_only_event().kind, Kind::rejected);
  const std::vector<Datagram> replies = received_by(second);
  ASSERT_EQ(replies.size(), 1U);
  EXPECT_FALSE(std::get<Welcome>(replies[0].message).accepted);
  EXPECT_EQ(hub_->peer(HubPeers::kHapticsSlot).sender, 20U);

  send(second, ForceCommand{});
  EXPECT_TRUE(take_events().empty());
  EXPECT_EQ(hub_->counts().unknown_peers, 1U);
}

TEST_F(HubPeersTest, AHapticsNodeThatRepliesKeepsItsSlotBetweenHellos) {
  RawNode first = raw_node(2, 20);
  RawNode second = raw_node(3, 30);
  send(first, Hello{NodeRole::haptics}, 0);
  for (int i = 0; i < 200; ++i) {
    clock_.advance_ns(kMs);
    send(first, ForceCommand{.echo_sample = 1});
    send(second, Hello{NodeRole::haptics}, 0);
  }
  int rejected = 0;
  for (const PeerEvent& e : take_events()) {
    rejected += e.kind == Kind::rejected ? 1 : 0;
  }
  EXPECT_EQ(rejected, 200);
}

TEST_F(HubPeersTest, TheHapticsSlotIsFreeFiftyMillisecondsAfterTheLastDatagram) {
  RawNode first = raw_node(2, 20);
  RawNode second = raw_node(3, 30);
  send(first, Hello{NodeRole::haptics}, 0);
  take_only_event();
  clock_.advance_ns(HubPeers::kHapticsTimeoutNs + 1);
  send(second, Hello{NodeRole::haptics}, 0);
  const PeerEvent joined = take_only_event();
  EXPECT_EQ(joined.kind, Kind::joined);
  EXPECT_TRUE(joined.replaced);
  EXPECT_EQ(hub_->peer(HubPeers::kHapticsSlot).sender, 30U);
}

TEST_F(HubPeersTest, AHapticsNodeThatHasLittleToSendKeepsItsSlotLonger) {
  RawNode first = raw_node(2, 20);
  RawNode second = raw_node(3, 30);
  send(first, Hello{NodeRole::haptics}, 0);
  take_only_event();
  hub_->set_haptics_timeout_ns(4 * HubPeers::kHapticsTimeoutNs);
  clock_.advance_ns(4 * HubPeers::kHapticsTimeoutNs);
  send(second, Hello{NodeRole::haptics}, 0);
  EXPECT_EQ(take_only_event().kind, Kind::rejected);
  clock_.advance_ns(1);
  send(second, Hello{NodeRole::haptics}, 0);
  EXPECT_EQ(take_only_event().kind, Kind::joined);
}

TEST_F(HubPeersTest, AByeFreesTheHapticsSlotAtOnce) {
  RawNode first = raw_node(2, 20);
  RawNode second = raw_node(3, 30);
  send(first, Hello{NodeRole::haptics}, 0);
  take_only_event();
  send(first, Bye{});
  EXPECT_EQ(take_only_event().kind, Kind::left);
  EXPECT_FALSE(hub_->has_haptics());
  send(second, Hello{NodeRole::haptics}, 0);
  EXPECT_EQ(take_only_event().kind, Kind::joined);
}

TEST_F(HubPeersTest, ARestartedProcessOnTheSameAddressTakesItsOwnSlotBack) {
  RawNode node = raw_node(2, 20);
  send(node, Hello{NodeRole::haptics}, 0);
  take_only_event();
  node.sender = 21;
  node.sequence = 0;
  send(node, Hello{NodeRole::haptics}, 0);
  const PeerEvent joined = take_only_event();
  EXPECT_EQ(joined.kind, Kind::joined);
  EXPECT_TRUE(joined.replaced);
  send(node, ForceCommand{});
  EXPECT_EQ(take_only_event().kind, Kind::message);
  EXPECT_EQ(hub_->peer(joined.peer).tracker.counts().restarts, 0U);
}

TEST_F(HubPeersTest, DropsTheSilentAfterASecond) {
  RawNode quiet = raw_node(2, 20);
  RawNode lively = raw_node(3, 30);
  send(quiet, Hello{NodeRole::vision}, 0);
  send(lively, Hello{NodeRole::tool}, 0);
  EXPECT_EQ(take_events().size(), 2U);
  clock_.advance_ns(600 * kMs);
  send(lively, Settings{});
  take_only_event();
  clock_.advance_ns(600 * kMs);
  const PeerEvent left = take_only_event();
  EXPECT_EQ(left.kind, Kind::left);
  EXPECT_EQ(left.role, NodeRole::vision);
  EXPECT_EQ(hub_->counts().timeouts, 1U);
  EXPECT_EQ(hub_->count(NodeRole::tool), 1U);
}

TEST_F(HubPeersTest, ItsNumbersGoOnForAPeerThatReturns) {
  RawNode node = raw_node(2, 20);
  send(node, Hello{NodeRole::vision}, 0);
  take_events();
  for (int n = 0; n < 10; ++n) hub_->send_to_role(NodeRole::vision, ProbeState{});
  const std::uint64_t last = received_by(node).back().header.sequence;
  clock_.advance_ns(1200 * kMs);
  EXPECT_EQ(take_only_event().kind, Kind::left);
  send(node, Hello{NodeRole::vision}, 0);
  EXPECT_EQ(take_only_event().kind, Kind::joined);
  EXPECT_EQ(received_by(node).front().header.sequence, last + 1);
}

// Another node had its slot in the meantime, and has left.
TEST_F(HubPeersTest, ItsNumbersGoOnForAPeerWhoseSlotWasTaken) {
  RawNode first = raw_node(2, 20);
  RawNode second = raw_node(3, 30);
  send(first, Hello{NodeRole::haptics}, 0);
  take_events();
  for (int n = 0; n < 500; ++n) hub_->send_to_role(NodeRole::haptics, DeviceState{});
  const std::uint64_t last = received_by(first).back().header.sequence;
  clock_.advance_ns(60 * kMs);
  send(second, Hello{NodeRole::haptics}, 0);
  ASSERT_EQ(take_only_event().kind, Kind::joined);
  send(second, Bye{});
  ASSERT_EQ(take_only_event().kind, Kind::left);
  send(first, Hello{NodeRole::haptics}, 0);
  ASSERT_EQ(take_only_event().kind, Kind::joined);
  EXPECT_GT(received_by(first).front().header.sequence, last) << "lower numbers would count as old";
}

TEST_F(HubPeersTest, SendsToOneRoleOnly) {
  RawNode haptics = raw_node(2, 20);
  RawNode vision = raw_node(3, 30);
  RawNode another = raw_node(4, 40);
  send(haptics, Hello{NodeRole::haptics}, 0);
  send(vision, Hello{NodeRole::vision}, 0);
  send(another, Hello{NodeRole::vision}, 0);
  take_events();
  EXPECT_EQ(hub_->send_to_role(NodeRole::vision, ProbeState{}), 2U);
  EXPECT_EQ(hub_->send_to_role(NodeRole::tool, ProbeState{}), 0U);
  EXPECT_EQ(received_by(haptics).size(), 1U);
  const std::vector<Datagram> received = received_by(another);
  ASSERT_EQ(received.size(), 2U);
  EXPECT_EQ(received[1].header.sequence, 2U);
  EXPECT_FALSE(hub_->send_to(99, Bye{}));
}

TEST_F(HubPeersTest, CountsAndDropsWhatDoesNotBelong) {
  RawNode node = raw_node(2, 20);
  send(node, Hello{NodeRole::vision}, 0);
  take_only_event();

  send(node, FrameAck{}, kSession + 1);
  EXPECT_TRUE(take_events().empty());
  EXPECT_EQ(hub_->counts().other_session, 1U);

  RawNode thief = raw_node(3, 20);
  send(thief, FrameAck{});
  send(thief, Hello{NodeRole::vision});
  EXPECT_TRUE(take_events().empty());
  EXPECT_EQ(hub_->counts().unknown_peers, 2U);

  send(node, ForceCommand{.force_n = Vec3(1, 0, 0)});
  send(node, DeviceState{});
  send(node, Welcome{});
  EXPECT_TRUE(take_events().empty());
  EXPECT_EQ(hub_->counts().wrong_role, 3U);

  const std::array<std::byte, 3> rubbish = {std::byte{0x08}, std::byte{0x09}, std::byte{1}};
  node.endpoint->send(hub_endpoint_->local_address(), rubbish);
  EXPECT_TRUE(take_events().empty());
  EXPECT_EQ(hub_->counts().undecodable, 1U);
  EXPECT_EQ(hub_->counts().wrong_version, 1U);

  RawNode impostor = raw_node(4, 40);
  send(impostor, Hello{NodeRole::io}, 0);
  EXPECT_TRUE(take_events().empty());
}

TEST_F(HubPeersTest, DropsDuplicatesAndMarksTheOvertaken) {
  RawNode node = raw_node(2, 20);
  send(node, Hello{NodeRole::haptics}, 0);
  take_only_event();
  node.sequence = 10;
  send(node, ForceCommand{});
  EXPECT_EQ(take_only_event().arrival, Arrival::newest);
  node.sequence = 5;
  send(node, ForceCommand{});
  EXPECT_EQ(take_only_event().arrival, Arrival::reordered);
  node.sequence = 5;
  send(node, ForceCommand{});
  EXPECT_TRUE(take_events().empty());
  EXPECT_EQ(hub_->peer(HubPeers::kHapticsSlot).tracker.counts().duplicate, 1U);
}

TEST_F(HubPeersTest, AFullTableRejectsButKeepsTheSlotOfTheHapticsNode) {
  std::vector<RawNode> nodes;
  for (std::uint8_t i = 0; i < HubPeers::kCapacity; ++i) {
    nodes.push_back(raw_node(static_cast<std::uint8_t>(10 + i), 100U + i));
    send(nodes.back(), Hello{NodeRole::vision}, 0);
  }
  EXPECT_EQ(take_events().size(), HubPeers::kCapacity);
  EXPECT_EQ(hub_->count(NodeRole::vision), HubPeers::kCapacity - 1);
  EXPECT_EQ(hub_->counts().rejections, 1U);
  RawNode haptics = raw_node(2, 20);
  send(haptics, Hello{NodeRole::haptics}, 0);
  EXPECT_EQ(take_only_event().kind, Kind::joined);
}

TEST_F(HubPeersTest, AFloodFromOneAddressTakesOneSlotAndNoHeap) {
  constexpr std::uint64_t kSeed = 99;
  RecordProperty("seed", std::to_string(kSeed));
  std::mt19937_64 random(kSeed);
  RawNode haptics = raw_node(2, 20);
  send(haptics, Hello{NodeRole::haptics}, 0);
  take_events();
  const Address from = memory_address(66, 6);
  Bytes bytes;
  const AllocationGuard guard;
  std::uint64_t allocations = 0;
  for (int i = 0; i < 20'000; ++i) {
    const Message message = i % 3 == 0 ? Message(Hello{NodeRole::tool}) : Message(ForceCommand{.force_n = Vec3(99, 0, 0)});
    const std::size_t size = codec_.encode({{random() % 2 == 0 ? kSession : random(), random() | 1U, random(), 0}, message}, bytes);
    clock_.advance_ns(1000);
    // Passed straight to the hub, because the memory network would allocate for a datagram.
    const std::uint64_t before = guard.count();
    const PeerEvent e = hub_->handle_datagram(std::span(bytes).first(size), from, clock_.now_ns(), datagram_);
    allocations += guard.count() - before;
    ASSERT_NE(e.kind, Kind::message);
  }
  EXPECT_EQ(hub_->count(NodeRole::tool), 1U);
  EXPECT_EQ(hub_->peer(HubPeers::kHapticsSlot).sender, 20U);
  EXPECT_GT(hub_->counts().unknown_peers, 1000U);
  EXPECT_GT(hub_->counts().other_session, 1000U);
  if (AllocationGuard::is_available()) {
    EXPECT_EQ(allocations, 0U);
  }
}

TEST_F(HubPeersTest, ReportsARejectedViewToItsSender) {
  RawNode vision = raw_node(2, 20);
  RawNode other = raw_node(3, 30);
  RawNode tool = raw_node(4, 40);
  send(vision, Hello{NodeRole::vision}, 0);
  send(other, Hello{NodeRole::vision}, 0);
  send(tool, Hello{NodeRole::tool}, 0);
  EXPECT_EQ(take_events().size(), 3U);
  received_by(vision);
  received_by(other);
  received_by(tool);
  const ViewTransform scaled{.revision = 7, .X_WS = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0}};
  send(vision, scaled, kSession);
  EXPECT_TRUE(take_events().empty());
  const std::vector<Datagram> sent_to_vision = received_by(vision);
  ASSERT_EQ(sent_to_vision.size(), 1U);
  ASSERT_TRUE(std::holds_alternative<ViewRejected>(sent_to_vision[0].message));
  EXPECT_EQ(std::get<ViewRejected>(sent_to_vision[0].message).revision, 7U);
  EXPECT_TRUE(received_by(other).empty());
  EXPECT_EQ(hub_->counts().views_rejected, 1U);
  EXPECT_EQ(hub_->counts().undecodable, 1U);
  // A peer that may not send a view, or has not joined, gets no reply.
  send(tool, scaled, kSession);
  EXPECT_TRUE(take_events().empty());
  EXPECT_TRUE(received_by(tool).empty());
  RawNode unknown = raw_node(5, 50);
  send(unknown, scaled, kSession);
  EXPECT_TRUE(take_events().empty());
  EXPECT_TRUE(received_by(unknown).empty());
  EXPECT_EQ(hub_->counts().views_rejected, 1U);
  EXPECT_EQ(hub_->counts().wrong_role, 1U);
  EXPECT_EQ(hub_->counts().unknown_peers, 1U);
}

TEST_F(HubPeersTest, SaysByeToEveryoneWhenItGoes) {
  RawNode node = raw_node(2, 20);
  send(node, Hello{NodeRole::tool}, 0);
  take_only_event();
  received_by(node);
  hub_.reset();
  const std::vector<Datagram> last = received_by(node);
  ASSERT_EQ(last.size(), 1U);
  EXPECT_TRUE(std::holds_alternative<Bye>(last[0].message));
}

}  // namespace
}  // namespace hapton::hub_peers
