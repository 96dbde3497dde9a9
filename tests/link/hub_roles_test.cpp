// Which role may send what.
#include <gtest/gtest.h>

#include <variant>

#include "tests/link/hub_peers_fixture.h"

namespace hapton::hub_peers {
namespace {

// What a sender may do if its datagrams are sealed with the key of a role.
class RoleRights : public HubPeersTest {
 protected:
  PeerEvent deliver(KeyRole key_role, const Message& message, std::uint64_t sender = 30, const Address& from = memory_address(3, 9)) {
    Bytes bytes;
    const std::size_t size = codec_.encode({{kSession, sender, ++sequence_, clock_.now_ns()}, message}, bytes);
    return hub_->handle_datagram(std::span(bytes).first(size), from, clock_.now_ns(), datagram_, key_role);
  }

  std::uint64_t sequence_ = 0;
};

TEST_F(RoleRights, AKeyJoinsAsItsOwnRoleAlone) {
  for (const KeyRole key_role : {KeyRole::haptics, KeyRole::vision, KeyRole::tool, KeyRole::operator_role, KeyRole::master}) {
    for (const NodeRole role : {NodeRole::haptics, NodeRole::vision, NodeRole::tool}) {
      hub_.emplace(*hub_endpoint_, clock_, kSession, kRateHz);
      const bool is_own = (key_role == KeyRole::haptics && role == NodeRole::haptics) ||
                          (key_role == KeyRole::vision && role == NodeRole::vision) ||
                          ((key_role == KeyRole::tool || key_role == KeyRole::operator_role) && role == NodeRole::tool);
      const PeerEvent event = deliver(key_role, Hello{role});
      EXPECT_EQ(event.kind == Kind::joined, is_own) << to_string(key_role);
      EXPECT_EQ(hub_->counts().role_violations, is_own ? 0U : 1U);
      if (is_own) {
        EXPECT_EQ(hub_->peer(event.peer).key_role, key_role);
      }
    }
  }
}

TEST_F(RoleRights, APeerIsAcceptedUnderItsOwnKeyAlone) {
  ASSERT_EQ(deliver(KeyRole::haptics, Hello{NodeRole::haptics}).kind, Kind::joined);
  EXPECT_EQ(deliver(KeyRole::vision, ForceCommand{}).kind, Kind::none);
  EXPECT_EQ(deliver(KeyRole::tool, Bye{}).kind, Kind::none);
  EXPECT_EQ(deliver(KeyRole::operator_role, Hello{NodeRole::haptics}).kind, Kind::none);
  EXPECT_EQ(hub_->counts().role_violations, 3U);
  EXPECT_TRUE(hub_->has_haptics());
  EXPECT_EQ(deliver(KeyRole::haptics, ForceCommand{}).kind, Kind::message);
}

TEST_F(RoleRights, EachRoleSendsWhatIsItsOwn) {
  const MaterialRequest material{.request = 1, .change = {.fields = MaterialChange::kDamping}};
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
  // Kinds that only the hub sends, that every role may send, and that two roles may send (below).
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
    ASSERT_EQ(deliver(nodes[n].second, Hello{nodes[n].first}, 100 + n, at).kind, Kind::joined);
    for (const auto& [message, owner] : messages) {
      const PeerEvent event = deliver(nodes[n].second, message, 100 + n, at);
      EXPECT_EQ(event.kind == Kind::message, owner == nodes[n].first) << message.index();
    }
  }
  EXPECT_EQ(hub_->counts().wrong_role, 2 * messages.size());
  // Two roles may send each of these: haptics and vision the first two kinds, vision and tool the other two.
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const Address at = memory_address(static_cast<std::uint8_t>(10 + n), 9);
    EXPECT_EQ(deliver(nodes[n].second, SceneFacts{}, 100 + n, at).kind == Kind::message, nodes[n].first != NodeRole::tool);
    EXPECT_EQ(deliver(nodes[n].second, ObjectPose{.serial = 1}, 100 + n, at).kind == Kind::message, nodes[n].first != NodeRole::tool);
    const MoveRequest move{.request = 1, .p_m = Vec3::Zero()};
    EXPECT_EQ(deliver(nodes[n].second, move, 100 + n, at).kind == Kind::message, nodes[n].first != NodeRole::haptics);
    const ShapeRequest shape{.stream = 1, .shape = 1, .part = {.total = 1}};
    EXPECT_EQ(deliver(nodes[n].second, shape, 100 + n, at).kind == Kind::message, nodes[n].first != NodeRole::haptics);
  }
}

}  // namespace
}  // namespace hapton::hub_peers
