#include "link/hub_peers.h"

#include <algorithm>

#include "link/random_id.h"

namespace hapton {
namespace {

constexpr std::size_t kNoSlot = HubPeers::kCapacity;

bool may_send(NodeRole role, const Message& message) {
  if (std::holds_alternative<Marker>(message)) return true;
  if (std::holds_alternative<SceneFacts>(message)) return role != NodeRole::tool;
  if (role == NodeRole::haptics) {
    return std::holds_alternative<ForceCommand>(message) || std::holds_alternative<HapticsSetup>(message) ||
           std::holds_alternative<MaterialState>(message) || std::holds_alternative<ObjectPose>(message) ||
           std::holds_alternative<MoveReply>(message) || std::holds_alternative<ObjectMove>(message) ||
           std::holds_alternative<Carves>(message) || std::holds_alternative<ShapeReply>(message) ||
           std::holds_alternative<ObjectShape>(message) || std::holds_alternative<ShapeStart>(message) || is_scene_part(message);
  }
  if (std::holds_alternative<MoveRequest>(message) || std::holds_alternative<ShapeRequest>(message)) return true;
  if (role == NodeRole::tool) {
    return std::holds_alternative<Settings>(message) || std::holds_alternative<MaterialRequest>(message) ||
           std::holds_alternative<ReportRequest>(message);
  }
  return std::holds_alternative<ViewTransform>(message) || std::holds_alternative<FrameAck>(message) ||
         std::holds_alternative<HandTarget>(message) || std::holds_alternative<ObjectPose>(message) ||
         std::holds_alternative<CarveStatus>(message) || std::holds_alternative<CarveUndo>(message) ||
         std::holds_alternative<ShapeStatus>(message);
}

bool may_join(KeyRole key_role, NodeRole role) {
  switch (key_role) {
    case KeyRole::unsealed:
      return true;
    case KeyRole::haptics:
      return role == NodeRole::haptics;
    case KeyRole::vision:
      return role == NodeRole::vision;
    case KeyRole::tool:
    case KeyRole::operator_role:
      return role == NodeRole::tool;
    case KeyRole::master:
      break;
  }
  return false;
}

}  // namespace

HubPeers::HubPeers(Endpoint& endpoint, const Clock& clock, std::uint64_t session, double servo_rate_hz)
    : endpoint_(endpoint), clock_(clock), session_(session), sender_(make_random_id()), servo_rate_hz_(servo_rate_hz) {}

HubPeers::~HubPeers() {
  for (std::size_t slot = 0; slot < kCapacity; ++slot) {
    if (peers_[slot].present) {
      send_to(slot, Bye{});
    }
  }
}

PeerEvent HubPeers::receive(Datagram& datagram, std::int64_t deadline_ns) noexcept {
  if (const PeerEvent silent = drop_timed_out(clock_.now_ns()); silent.kind != PeerEvent::Kind::none) {
    return silent;
  }
  const Received received = endpoint_.receive(buffer_, deadline_ns);
  if (received.bytes == 0) {
    return {};
  }
  return handle_datagram(std::span(buffer_).first(received.bytes), received.from, clock_.now_ns(), datagram, received.role);
}

PeerEvent HubPeers::handle_datagram(std::span<const std::byte> bytes, const Address& from, std::int64_t now_ns, Datagram& datagram,
                                    KeyRole key_role) noexcept {
  ++counts_.received;
  if (tap_ != nullptr) tap_->on_received(from, bytes, now_ns);
  const DecodeStatus status = codec_.decode(bytes, datagram);
  if (status != DecodeStatus::ok) {
    ++counts_.undecodable;
    counts_.wrong_version += status == DecodeStatus::wrong_version ? 1 : 0;
    if (status == DecodeStatus::not_rigid) reject_view(datagram, from, now_ns, key_role);
    return {};
  }
  if (const auto* hello = std::get_if<Hello>(&datagram.message)) {
    return welcome(datagram.header, hello->role, from, now_ns, key_role);
  }
  return accept_message(datagram, from, now_ns, key_role);
}

// Only a peer that may send views gets a reply.
void HubPeers::reject_view(const Datagram& datagram, const Address& from, std::int64_t now_ns, KeyRole key_role) noexcept {
  const PeerEvent event = accept_message(datagram, from, now_ns, key_role);
  if (event.kind != PeerEvent::Kind::message) return;
  ++counts_.views_rejected;
  send_to(event.peer, ViewRejected{std::get<ViewTransform>(datagram.message).revision});
}

PeerEvent HubPeers::accept_message(const Datagram& datagram, const Address& from, std::int64_t now_ns, KeyRole key_role) noexcept {
  if (datagram.header.session != session_) {
    ++counts_.other_session;
    return {};
  }
  const std::size_t slot = find(datagram.header.sender);
  if (slot == kNoSlot || peers_[slot].address != from) {
    ++counts_.unknown_peers;
    return {};
  }
  Peer& peer = peers_[slot];
  if (peer.key_role != key_role) {
    ++counts_.role_violations;
    return {};
  }
  const Arrival arrival = peer.tracker.track(datagram.header.sender, datagram.header.sequence);
  if (arrival == Arrival::duplicate || arrival == Arrival::stale) {
    return {};
  }
  peer.last_received_ns = now_ns;
  if (std::holds_alternative<Bye>(datagram.message)) {
    return leave(slot, now_ns);
  }
  if (!may_send(peer.role, datagram.message)) {
    ++counts_.wrong_role;
    return {};
  }
  const Arrival order = peer.order.note(peer.tracker, arrival, datagram.message, datagram.header.sequence);
  return {.kind = PeerEvent::Kind::message, .role = peer.role, .peer = slot, .arrival = order, .receive_time_ns = now_ns};
}

PeerEvent HubPeers::welcome(const Header& header, NodeRole role, const Address& from, std::int64_t now_ns, KeyRole key_role) noexcept {
  if (!may_join(key_role, role)) {
    ++counts_.role_violations;
    return {};
  }
  if (role == NodeRole::io || header.sender == 0) {
    ++counts_.unknown_peers;
    return {};
  }
  const std::size_t known = find(header.sender);
  if (known == kNoSlot) {
    const std::size_t slot = find_slot(role, from, now_ns);
    if (slot == kNoSlot) return reject(from, role, now_ns);
    const PeerEvent joined = join(slot, header, role, from, now_ns);
    peers_[slot].key_role = key_role;
    return joined;
  }
  Peer& peer = peers_[known];
  if (peer.address != from || peer.role != role || peer.key_role != key_role) {
    ++counts_.unknown_peers;
    return {};
  }
  peer.tracker.track(header.sender, header.sequence);
  peer.last_received_ns = now_ns;
  send_to(known, Welcome{true, servo_rate_hz_});
  return {};
}

PeerEvent HubPeers::reject(const Address& to, NodeRole role, std::int64_t now_ns) noexcept {
  ++counts_.rejections;
  transmit(to, ++rejection_sequence_, Welcome{false, servo_rate_hz_}, now_ns);
  return {.kind = PeerEvent::Kind::rejected, .role = role, .peer = kNoSlot, .receive_time_ns = now_ns};
}

PeerEvent HubPeers::join(std::size_t slot, const Header& header, NodeRole role, const Address& from, std::int64_t now_ns) noexcept {
  // If a peer was dropped and returns, the hub's sequence numbers continue: the peer would treat lower ones as old. Another peer may have
  // taken its slot meanwhile, so no peer's numbers begin below the highest number that any replaced peer has got.
  const auto known = std::find_if(peers_.begin(), peers_.end(), [&](const Peer& p) { return p.sender == header.sender; });
  Peer& peer = peers_[slot];
  const std::uint64_t sent = std::max({known != peers_.end() ? known->sent : 0, sent_to_replaced_, peer.sent});
  sent_to_replaced_ = std::max(sent_to_replaced_, peer.sent);
  const bool is_replaced = peer.present;
  peer = Peer();
  peer.sent = sent;
  peer.present = true;
  peer.role = role;
  peer.address = from;
  peer.sender = header.sender;
  peer.joined_ns = now_ns;
  peer.last_received_ns = now_ns;
  peer.tracker.track(header.sender, header.sequence);
  send_to(slot, Welcome{true, servo_rate_hz_});
  return {.kind = PeerEvent::Kind::joined, .role = role, .peer = slot, .replaced = is_replaced, .receive_time_ns = now_ns};
}

PeerEvent HubPeers::leave(std::size_t slot, std::int64_t now_ns) noexcept {
  peers_[slot].present = false;
  return {.kind = PeerEvent::Kind::left, .role = peers_[slot].role, .peer = slot, .receive_time_ns = now_ns};
}

PeerEvent HubPeers::drop_timed_out(std::int64_t now_ns) noexcept {
  for (std::size_t slot = 0; slot < kCapacity; ++slot) {
    if (peers_[slot].present && now_ns - peers_[slot].last_received_ns > kPeerTimeoutNs) {
      ++counts_.timeouts;
      return leave(slot, now_ns);
    }
  }
  return {};
}

std::size_t HubPeers::find(std::uint64_t sender) const noexcept {
  const auto found = std::find_if(peers_.begin(), peers_.end(), [&](const Peer& p) { return p.present && p.sender == sender; });
  return static_cast<std::size_t>(found - peers_.begin());
}

std::size_t HubPeers::find_slot(NodeRole role, const Address& from, std::int64_t now_ns) const noexcept {
  if (role == NodeRole::haptics) {
    const Peer& holder = peers_[kHapticsSlot];
    // Two running processes cannot share an address: a haptics node at the holder's address is its successor.
    const bool is_free = !holder.present || holder.address == from || now_ns - holder.last_received_ns > haptics_timeout_ns_;
    return is_free ? kHapticsSlot : kNoSlot;
  }
  std::size_t free_slot = kNoSlot;
  for (std::size_t slot = kHapticsSlot + 1; slot < kCapacity; ++slot) {
    if (peers_[slot].present && peers_[slot].address == from) {
      return slot;
    }
    if (!peers_[slot].present && free_slot == kNoSlot) {
      free_slot = slot;
    }
  }
  return free_slot;
}

std::size_t HubPeers::send_to_role(NodeRole role, const Message& message) noexcept {
  std::size_t reached = 0;
  for (std::size_t slot = 0; slot < kCapacity; ++slot) {
    if (peers_[slot].present && peers_[slot].role == role && send_to(slot, message)) {
      ++reached;
    }
  }
  return reached;
}

bool HubPeers::send_to(std::size_t slot, const Message& message) noexcept {
  if (slot >= kCapacity || !peers_[slot].present) {
    return false;
  }
  Peer& peer = peers_[slot];
  const bool is_sent = transmit(peer.address, ++peer.sent, message, clock_.now_ns());
  peer.send_failures += is_sent ? 0 : 1;
  return is_sent;
}

bool HubPeers::transmit(const Address& to, std::uint64_t sequence, const Message& message, std::int64_t now_ns) noexcept {
  outgoing_.header = {.session = session_, .sender = sender_, .sequence = sequence, .send_time_ns = now_ns};
  outgoing_.message = message;
  std::array<std::byte, kMaxDatagramBytes> bytes;
  const std::size_t size = codec_.encode(outgoing_, bytes);
  if (size == 0) return false;
  const bool is_sent = endpoint_.send(to, std::span(bytes).first(size));
  if (tap_ != nullptr && is_sent) tap_->on_sent(to, std::span(bytes).first(size), now_ns);
  return is_sent;
}

std::size_t HubPeers::count(NodeRole role) const noexcept {
  return static_cast<std::size_t>(std::count_if(peers_.begin(), peers_.end(), [&](const Peer& p) { return p.present && p.role == role; }));
}

}  // namespace hapton
