#include "link/hub_peers.h"

#include <gtest/gtest.h>

#include <random>
#include <set>
#include <variant>
#include <vector>

#include "link/hub_client.h"
#include "link/memory_endpoint.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

using Kind = PeerEvent::Kind;

constexpr std::uint64_t kSession = 777;
constexpr double kRate = 1000.0;

// A peer with hand-made datagrams.
struct RawNode {
  std::unique_ptr<Endpoint> endpoint;
  std::uint64_t sender = 0;
  std::uint64_t sequence = 0;
};

class HubPeersTest : public testing::Test {
 protected:
  HubPeersTest() { hub_.emplace(*hub_endpoint_, clock_, kSession, kRate); }

  RawNode raw_node(std::uint8_t host, std::uint64_t sender, std::uint16_t port = 9) {
    return {*network_.open(memory_address(host, port)), sender, 0};
  }

  void send(RawNode& node, const Message& message, std::uint64_t session = kSession) {
    Bytes bytes;
    const std::size_t size = codec_.encode({{session, node.sender, ++node.sequence, clock_.now_ns()}, message}, bytes);
    ASSERT_GT(size, 0U);
    node.endpoint->send(hub_endpoint_->local_address(), std::span(bytes).first(size));
  }

  // The hub's events from all that has come, timeouts included.
  std::vector<PeerEvent> events() {
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

  PeerEvent event() {
    const std::vector<PeerEvent> all = events();
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

TEST_F(HubPeersTest, WelcomesANodeWithSessionAndRate) {
  RawNode node = raw_node(2, 20);
  send(node, Hello{NodeRole::vision}, 0);
  const PeerEvent joined = event();
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
  EXPECT_EQ(welcome.servo_rate_hz, kRate);
}

TEST_F(HubPeersTest, RepliesToEveryHelloAndJoinsOnce) {
  RawNode node = raw_node(2, 20);
  send(node, Hello{NodeRole::vision}, 0);
  send(node, Hello{NodeRole::vision});
  EXPECT_EQ(events().size(), 1U);
  EXPECT_EQ(received_by(node).size(), 2U);
  EXPECT_EQ(hub_->count(NodeRole::vision), 1U);
}

TEST_F(HubPeersTest, RejectsASecondHapticsNodeWhileTheFirstLives) {
  RawNode first = raw_node(2, 20);
  RawNode second = raw_node(3, 30);
  send(first, Hello{NodeRole::haptics}, 0);
  EXPECT_EQ(event().peer, HubPeers::kHapticsSlot);
  clock_.advance_ns(HubPeers::kHapticsTimeoutNs);
  send(second, Hello{NodeRole::haptics}, 0);
  EXPECT_EQ(event().kind, Kind::rejected);
  const std::vector<Datagram> replies = received_by(second);
  ASSERT_EQ(replies.size(), 1U);
  EXPECT_FALSE(std::get<Welcome>(replies[0].message).accepted);
  EXPECT_EQ(hub_->peer(HubPeers::kHapticsSlot).sender, 20U);

  send(second, ForceCommand{});
  EXPECT_TRUE(events().empty());
  EXPECT_EQ(hub_->counts().unknown_peers, 1U);
}

TEST_F(HubPeersTest, AHapticsNodeThatRepliesKeepsItsPlaceBetweenHellos) {
  RawNode first = raw_node(2, 20);
  RawNode second = raw_node(3, 30);
  send(first, Hello{NodeRole::haptics}, 0);
  for (int i = 0; i < 200; ++i) {
    clock_.advance_ns(kMs);
    send(first, ForceCommand{.echo_sample = 1});
    send(second, Hello{NodeRole::haptics}, 0);
  }
  int rejected = 0;
  for (const PeerEvent& e : events()) {
    rejected += e.kind == Kind::rejected ? 1 : 0;
  }
  EXPECT_EQ(rejected, 200);
}

TEST_F(HubPeersTest, TheHapticsSlotIsFreeFiftyMillisecondsAfterTheLastDatagram) {
  RawNode first = raw_node(2, 20);
  RawNode second = raw_node(3, 30);
  send(first, Hello{NodeRole::haptics}, 0);
  event();
  clock_.advance_ns(HubPeers::kHapticsTimeoutNs + 1);
  send(second, Hello{NodeRole::haptics}, 0);
  const PeerEvent joined = event();
  EXPECT_EQ(joined.kind, Kind::joined);
  EXPECT_TRUE(joined.replaced);
  EXPECT_EQ(hub_->peer(HubPeers::kHapticsSlot).sender, 30U);
}

TEST_F(HubPeersTest, AHapticsNodeThatHasLittleToSendKeepsItsPlaceLonger) {
  RawNode first = raw_node(2, 20);
  RawNode second = raw_node(3, 30);
  send(first, Hello{NodeRole::haptics}, 0);
  event();
  hub_->set_haptics_timeout_ns(4 * HubPeers::kHapticsTimeoutNs);
  clock_.advance_ns(4 * HubPeers::kHapticsTimeoutNs);
  send(second, Hello{NodeRole::haptics}, 0);
  EXPECT_EQ(event().kind, Kind::rejected);
  clock_.advance_ns(1);
  send(second, Hello{NodeRole::haptics}, 0);
  EXPECT_EQ(event().kind, Kind::joined);
}

TEST_F(HubPeersTest, AByeFreesTheHapticsPlaceAtOnce) {
  RawNode first = raw_node(2, 20);
  RawNode second = raw_node(3, 30);
  send(first, Hello{NodeRole::haptics}, 0);
  event();
  send(first, Bye{});
  EXPECT_EQ(event().kind, Kind::left);
  EXPECT_FALSE(hub_->has_haptics());
  send(second, Hello{NodeRole::haptics}, 0);
  EXPECT_EQ(event().kind, Kind::joined);
}

TEST_F(HubPeersTest, ARestartedProcessOnTheSameAddressTakesItsOwnPlaceBack) {
  RawNode node = raw_node(2, 20);
  send(node, Hello{NodeRole::haptics}, 0);
  event();
  node.sender = 21;
  node.sequence = 0;
  send(node, Hello{NodeRole::haptics}, 0);
  const PeerEvent joined = event();
  EXPECT_EQ(joined.kind, Kind::joined);
  EXPECT_TRUE(joined.replaced);
  send(node, ForceCommand{});
  EXPECT_EQ(event().kind, Kind::message);
  EXPECT_EQ(hub_->peer(joined.peer).tracker.counts().restarts, 0U);
}

TEST_F(HubPeersTest, DropsTheSilentAfterASecond) {
  RawNode quiet = raw_node(2, 20);
  RawNode lively = raw_node(3, 30);
  send(quiet, Hello{NodeRole::vision}, 0);
  send(lively, Hello{NodeRole::tool}, 0);
  EXPECT_EQ(events().size(), 2U);
  clock_.advance_ns(600 * kMs);
  send(lively, Settings{});
  event();
  clock_.advance_ns(600 * kMs);
  const PeerEvent left = event();
  EXPECT_EQ(left.kind, Kind::left);
  EXPECT_EQ(left.role, NodeRole::vision);
  EXPECT_EQ(hub_->counts().timeouts, 1U);
  EXPECT_EQ(hub_->count(NodeRole::tool), 1U);
}

TEST_F(HubPeersTest, ItsNumbersGoOnForAPeerThatReturns) {
  RawNode node = raw_node(2, 20);
  send(node, Hello{NodeRole::vision}, 0);
  events();
  for (int n = 0; n < 10; ++n) hub_->send_to_role(NodeRole::vision, ProbeState{});
  const std::uint64_t last = received_by(node).back().header.sequence;
  clock_.advance_ns(1200 * kMs);
  EXPECT_EQ(event().kind, Kind::left);
  send(node, Hello{NodeRole::vision}, 0);
  EXPECT_EQ(event().kind, Kind::joined);
  EXPECT_EQ(received_by(node).front().header.sequence, last + 1);
}

// Another one had its place meanwhile, and has left.
TEST_F(HubPeersTest, ItsNumbersGoOnForAPeerWhosePlaceWasTaken) {
  RawNode first = raw_node(2, 20);
  RawNode second = raw_node(3, 30);
  send(first, Hello{NodeRole::haptics}, 0);
  events();
  for (int n = 0; n < 500; ++n) hub_->send_to_role(NodeRole::haptics, DeviceState{});
  const std::uint64_t last = received_by(first).back().header.sequence;
  clock_.advance_ns(60 * kMs);
  send(second, Hello{NodeRole::haptics}, 0);
  ASSERT_EQ(event().kind, Kind::joined);
  send(second, Bye{});
  ASSERT_EQ(event().kind, Kind::left);
  send(first, Hello{NodeRole::haptics}, 0);
  ASSERT_EQ(event().kind, Kind::joined);
  EXPECT_GT(received_by(first).front().header.sequence, last) << "lower numbers would count as old";
}

TEST_F(HubPeersTest, SendsToOneRoleOnly) {
  RawNode haptics = raw_node(2, 20);
  RawNode vision = raw_node(3, 30);
  RawNode another = raw_node(4, 40);
  send(haptics, Hello{NodeRole::haptics}, 0);
  send(vision, Hello{NodeRole::vision}, 0);
  send(another, Hello{NodeRole::vision}, 0);
  events();
  EXPECT_EQ(hub_->send_to_role(NodeRole::vision, ProbeState{}), 2U);
  EXPECT_EQ(hub_->send_to_role(NodeRole::tool, ProbeState{}), 0U);
  EXPECT_EQ(received_by(haptics).size(), 1U);
  const std::vector<Datagram> seen = received_by(another);
  ASSERT_EQ(seen.size(), 2U);
  EXPECT_EQ(seen[1].header.sequence, 2U);
  EXPECT_FALSE(hub_->send_to(99, Bye{}));
}

TEST_F(HubPeersTest, CountsAndDropsWhatDoesNotBelong) {
  RawNode node = raw_node(2, 20);
  send(node, Hello{NodeRole::vision}, 0);
  event();

  send(node, FrameAck{}, kSession + 1);
  EXPECT_TRUE(events().empty());
  EXPECT_EQ(hub_->counts().other_session, 1U);

  RawNode thief = raw_node(3, 20);
  send(thief, FrameAck{});
  send(thief, Hello{NodeRole::vision});
  EXPECT_TRUE(events().empty());
  EXPECT_EQ(hub_->counts().unknown_peers, 2U);

  send(node, ForceCommand{.force_n = Vec3(1, 0, 0)});
  send(node, DeviceState{});
  send(node, Welcome{});
  EXPECT_TRUE(events().empty());
  EXPECT_EQ(hub_->counts().wrong_role, 3U);

  const std::array<std::byte, 3> rubbish = {std::byte{0x08}, std::byte{0x09}, std::byte{1}};
  node.endpoint->send(hub_endpoint_->local_address(), rubbish);
  EXPECT_TRUE(events().empty());
  EXPECT_EQ(hub_->counts().undecodable, 1U);
  EXPECT_EQ(hub_->counts().wrong_version, 1U);

  RawNode impostor = raw_node(4, 40);
  send(impostor, Hello{NodeRole::io}, 0);
  EXPECT_TRUE(events().empty());
}

TEST_F(HubPeersTest, DropsDuplicatesAndMarksTheOvertaken) {
  RawNode node = raw_node(2, 20);
  send(node, Hello{NodeRole::haptics}, 0);
  event();
  node.sequence = 10;
  send(node, ForceCommand{});
  EXPECT_EQ(event().arrival, Arrival::newest);
  node.sequence = 5;
  send(node, ForceCommand{});
  EXPECT_EQ(event().arrival, Arrival::reordered);
  node.sequence = 5;
  send(node, ForceCommand{});
  EXPECT_TRUE(events().empty());
  EXPECT_EQ(hub_->peer(HubPeers::kHapticsSlot).tracker.counts().duplicate, 1U);
}

TEST_F(HubPeersTest, AFullTableRejectsButKeepsThePlaceOfTheHapticsNode) {
  std::vector<RawNode> nodes;
  for (std::uint8_t i = 0; i < HubPeers::kCapacity; ++i) {
    nodes.push_back(raw_node(static_cast<std::uint8_t>(10 + i), 100U + i));
    send(nodes.back(), Hello{NodeRole::vision}, 0);
  }
  EXPECT_EQ(events().size(), HubPeers::kCapacity);
  EXPECT_EQ(hub_->count(NodeRole::vision), HubPeers::kCapacity - 1);
  EXPECT_EQ(hub_->counts().rejections, 1U);
  RawNode haptics = raw_node(2, 20);
  send(haptics, Hello{NodeRole::haptics}, 0);
  EXPECT_EQ(event().kind, Kind::joined);
}

TEST_F(HubPeersTest, AFloodFromOneAddressTakesOnePlaceAndNoHeap) {
  constexpr std::uint64_t kSeed = 99;
  RecordProperty("seed", std::to_string(kSeed));
  std::mt19937_64 random(kSeed);
  RawNode haptics = raw_node(2, 20);
  send(haptics, Hello{NodeRole::haptics}, 0);
  events();
  const Address from = memory_address(66, 6);
  Bytes bytes;
  const AllocationGuard guard;
  std::uint64_t allocations = 0;
  for (int i = 0; i < 20'000; ++i) {
    const Message message = i % 3 == 0 ? Message(Hello{NodeRole::tool}) : Message(ForceCommand{.force_n = Vec3(99, 0, 0)});
    const std::size_t size = codec_.encode({{random() % 2 == 0 ? kSession : random(), random() | 1U, random(), 0}, message}, bytes);
    clock_.advance_ns(1000);
    // Straight into the hub: the memory network would allocate for the reply only.
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

// What a datagram sealed with a role's key can do.
class RoleRights : public HubPeersTest {
 protected:
  PeerEvent say(KeyRole key_role, const Message& message, std::uint64_t sender = 30, const Address& from = memory_address(3, 9)) {
    Bytes bytes;
    const std::size_t size = codec_.encode({{kSession, sender, ++sequence_, clock_.now_ns()}, message}, bytes);
    return hub_->handle_datagram(std::span(bytes).first(size), from, clock_.now_ns(), datagram_, key_role);
  }

  std::uint64_t sequence_ = 0;
};

TEST_F(RoleRights, AKeyJoinsAsItsOwnRoleAlone) {
  for (const KeyRole key_role : {KeyRole::haptics, KeyRole::vision, KeyRole::tool, KeyRole::operator_role, KeyRole::master}) {
    for (const NodeRole role : {NodeRole::haptics, NodeRole::vision, NodeRole::tool}) {
      hub_.emplace(*hub_endpoint_, clock_, kSession, kRate);
      const bool is_own = (key_role == KeyRole::haptics && role == NodeRole::haptics) ||
                          (key_role == KeyRole::vision && role == NodeRole::vision) ||
                          ((key_role == KeyRole::tool || key_role == KeyRole::operator_role) && role == NodeRole::tool);
      const PeerEvent event = say(key_role, Hello{role});
      EXPECT_EQ(event.kind == Kind::joined, is_own) << to_string(key_role);
      EXPECT_EQ(hub_->counts().role_violations, is_own ? 0U : 1U);
      if (is_own) {
        EXPECT_EQ(hub_->peer(event.peer).key_role, key_role);
      }
    }
  }
}

TEST_F(RoleRights, APeerIsAcceptedUnderItsOwnKeyAlone) {
  ASSERT_EQ(say(KeyRole::haptics, Hello{NodeRole::haptics}).kind, Kind::joined);
  EXPECT_EQ(say(KeyRole::vision, ForceCommand{}).kind, Kind::none);
  EXPECT_EQ(say(KeyRole::tool, Bye{}).kind, Kind::none);
  EXPECT_EQ(say(KeyRole::operator_role, Hello{NodeRole::haptics}).kind, Kind::none);
  EXPECT_EQ(hub_->counts().role_violations, 3U);
  EXPECT_TRUE(hub_->has_haptics());
  EXPECT_EQ(say(KeyRole::haptics, ForceCommand{}).kind, Kind::message);
}

TEST_F(RoleRights, EachRoleSendsWhatIsItsOwn) {
  const MaterialRequest material{.request = 1, .change = {.given = MaterialChange::kDamping}};
  const std::vector<std::pair<Message, NodeRole>> messages = {
      {ForceCommand{}, NodeRole::haptics},
      {HapticsSetup{}, NodeRole::haptics},
      {ViewTransform{}, NodeRole::vision},
      {FrameAck{}, NodeRole::vision},
      {HandTarget{}, NodeRole::vision},
      {Settings{}, NodeRole::tool},
      {ReportRequest{}, NodeRole::tool},
      {material, NodeRole::tool},
      {MaterialState{}, NodeRole::haptics},
      {MoveReply{.request = 1}, NodeRole::haptics},
      {ObjectMove{.source = 1}, NodeRole::haptics},
      {Carves{.source = 1}, NodeRole::haptics},
      {PatchBegin{.epoch = 1, .step_m = 1e-8}, NodeRole::haptics},
      {PatchCell{.epoch = 1}, NodeRole::haptics},
      {PatchTile{.epoch = 1, .vertex_count = 1, .triangle_count = 1}, NodeRole::haptics},
      {PatchDeformation{.epoch = 1, .tile_count = 1, .target_count = 1, .all_keys = 1, .key_count = 1}, NodeRole::haptics},
      {PatchDisplacements{.epoch = 1, .vertex_count = 1}, NodeRole::haptics},
      {PatchStream{.epoch = 1, .tile_count = 1, .total = 1, .reach_m = 1.0, .vertex_count = 1}, NodeRole::haptics},
      {PatchEffects{.epoch = 1, .byte_count = 1}, NodeRole::haptics},
      {PatchBody{.epoch = 1}, NodeRole::haptics},
      {PatchMaterial{.epoch = 1}, NodeRole::haptics},
      {CarveStatus{.source = 1}, NodeRole::vision},
      {CarveUndo{.source = 1, .serial = 1}, NodeRole::vision},
      {ShapeReply{.stream = 1, .shape = 1}, NodeRole::haptics},
      {ObjectShape{.source = 1, .serial = 1, .part = {.total = 1}}, NodeRole::haptics},
      {ShapeStart{.source = 1, .total = 1}, NodeRole::haptics},
      {ShapeStatus{.source = 1, .serial = 1}, NodeRole::vision}};
  // The hub's own, those of every role, and those of two roles, below.
  const std::vector<Message> others = {Hello{},      Welcome{},    Bye{},          DeviceState{}, ProbeState{},
                                       ReportPart{}, SceneFacts{}, ViewRejected{}, PatchStatus{}, LoopFacts{},
                                       ObjectPose{}, Marker{},     MarkerReply{},  MoveRequest{}, ShapeRequest{}};
  std::set<std::size_t> kinds;
  for (const auto& [message, owner] : messages) kinds.insert(message.index());
  for (const Message& message : others) kinds.insert(message.index());
  EXPECT_EQ(kinds.size(), std::variant_size_v<Message>) << "who may send a kind that is in neither list?";
  const std::vector<std::pair<NodeRole, KeyRole>> nodes = {
      {NodeRole::haptics, KeyRole::haptics}, {NodeRole::vision, KeyRole::vision}, {NodeRole::tool, KeyRole::tool}};
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const Address at = memory_address(static_cast<std::uint8_t>(10 + n), 9);
    ASSERT_EQ(say(nodes[n].second, Hello{nodes[n].first}, 100 + n, at).kind, Kind::joined);
    for (const auto& [message, owner] : messages) {
      const PeerEvent event = say(nodes[n].second, message, 100 + n, at);
      EXPECT_EQ(event.kind == Kind::message, owner == nodes[n].first) << message.index();
    }
  }
  EXPECT_EQ(hub_->counts().wrong_role, 2 * messages.size());
  // Two roles have a scene; where its objects are one says, and the other asks for.
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const Address at = memory_address(static_cast<std::uint8_t>(10 + n), 9);
    EXPECT_EQ(say(nodes[n].second, SceneFacts{}, 100 + n, at).kind == Kind::message, nodes[n].first != NodeRole::tool);
    EXPECT_EQ(say(nodes[n].second, ObjectPose{.serial = 1}, 100 + n, at).kind == Kind::message, nodes[n].first != NodeRole::tool);
    const MoveRequest move{.request = 1, .p_m = Vec3::Zero()};
    EXPECT_EQ(say(nodes[n].second, move, 100 + n, at).kind == Kind::message, nodes[n].first != NodeRole::haptics);
    const ShapeRequest shape{.stream = 1, .shape = 1, .part = {.total = 1}};
    EXPECT_EQ(say(nodes[n].second, shape, 100 + n, at).kind == Kind::message, nodes[n].first != NodeRole::haptics);
  }
}

TEST_F(HubPeersTest, ReportsARejectedViewToItsSender) {
  RawNode vision = raw_node(2, 20);
  RawNode other = raw_node(3, 30);
  RawNode tool = raw_node(4, 40);
  send(vision, Hello{NodeRole::vision}, 0);
  send(other, Hello{NodeRole::vision}, 0);
  send(tool, Hello{NodeRole::tool}, 0);
  EXPECT_EQ(events().size(), 3U);
  received_by(vision);
  received_by(other);
  received_by(tool);
  const ViewTransform scaled{.revision = 7, .X_WS = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0}};
  send(vision, scaled, kSession);
  EXPECT_TRUE(events().empty());
  const std::vector<Datagram> sent_to_vision = received_by(vision);
  ASSERT_EQ(sent_to_vision.size(), 1U);
  ASSERT_TRUE(std::holds_alternative<ViewRejected>(sent_to_vision[0].message));
  EXPECT_EQ(std::get<ViewRejected>(sent_to_vision[0].message).revision, 7U);
  EXPECT_TRUE(received_by(other).empty());
  EXPECT_EQ(hub_->counts().views_rejected, 1U);
  EXPECT_EQ(hub_->counts().undecodable, 1U);
  // A peer that may not send a view, or has not joined, gets no reply.
  send(tool, scaled, kSession);
  EXPECT_TRUE(events().empty());
  EXPECT_TRUE(received_by(tool).empty());
  RawNode unknown = raw_node(5, 50);
  send(unknown, scaled, kSession);
  EXPECT_TRUE(events().empty());
  EXPECT_TRUE(received_by(unknown).empty());
  EXPECT_EQ(hub_->counts().views_rejected, 1U);
  EXPECT_EQ(hub_->counts().wrong_role, 1U);
  EXPECT_EQ(hub_->counts().unknown_peers, 1U);
}

TEST_F(HubPeersTest, SaysByeToEveryoneWhenItGoes) {
  RawNode node = raw_node(2, 20);
  send(node, Hello{NodeRole::tool}, 0);
  event();
  received_by(node);
  hub_.reset();
  const std::vector<Datagram> last = received_by(node);
  ASSERT_EQ(last.size(), 1U);
  EXPECT_TRUE(std::holds_alternative<Bye>(last[0].message));
}

}  // namespace
}  // namespace hapton
