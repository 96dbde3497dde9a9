// Sealed datagrams of four nodes and their hub, in sessions with known keys: their opened content reaches the hub's table of nodes and a
// node's client. An opened datagram comes from the holder of the key; nobody can do more than the role of that key allows.
#include <array>

#include "link/hub_client.h"
#include "link/hub_peers.h"
#include "runtime/clock.h"
#include "tests/fuzz/fixed_random.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/sealed_session.h"

namespace hapton {
namespace {

constexpr std::uint64_t kHubSession = 1;
constexpr std::uint8_t kNodes = 4;

// The roles that the holder of a key may join as, from docs/security.md, independent of the product code.
NodeRole allowed_role(KeyRole role) {
  return role == KeyRole::haptics ? NodeRole::haptics : role == KeyRole::vision ? NodeRole::vision : NodeRole::tool;
}

// Discards what is sent. receive() returns the payload of the last hold(), once.
class OnePayloadEndpoint final : public Endpoint {
 public:
  bool send(const Address&, std::span<const std::byte> datagram) noexcept override {
    fuzz::require(datagram.size() <= seal::kMaxPayloadBytes);
    return true;
  }
  Received receive(std::span<std::byte> into, std::int64_t) noexcept override {
    const std::size_t size = std::exchange(payload_, {}).size();
    std::copy_n(buffer_.begin(), size, into.begin());
    return {.bytes = size, .from = address_of_hub_};
  }
  Address local_address() const override { return fuzz::address_of_node(0); }
  void hold(std::span<const std::byte> payload) {
    std::copy(payload.begin(), payload.end(), buffer_.begin());
    payload_ = std::span(buffer_).first(payload.size());
  }

 private:
  Address address_of_hub_ = fuzz::address_of_hub();
  std::array<std::byte, kMaxDatagramBytes> buffer_ = {};
  std::span<std::byte> payload_;
};

class Sessions {
 public:
  Sessions() {
    for (std::uint8_t node = 0; node < kNodes; ++node) {
      at_hub_[node] = fuzz::make_channel(node, SealedChannel::Side::hub);
      at_node_[node] = fuzz::make_channel(node, SealedChannel::Side::client);
    }
  }

  // Returns whether the seal of the datagram is valid.
  bool deliver(const fuzz::ListedDatagram& datagram) {
    clock_.advance_ns(datagram.pause_ns());
    SealedChannel& channel = (datagram.is_to_node() ? at_node_ : at_hub_)[datagram.node()];
    std::array<std::byte, kMaxDatagramBytes> into;
    std::size_t bytes = 0;
    const OpenStatus status = channel.open(fuzz::as_datagram(datagram.bytes), into, bytes);
    fuzz::require((status == OpenStatus::opened) == (bytes != 0) && bytes <= seal::kMaxPayloadBytes);
    if (bytes == 0) return false;
    datagram.is_to_node() ? to_node(std::span(into).first(bytes)) : to_hub(std::span(into).first(bytes), datagram);
    return true;
  }

 private:
  void to_hub(std::span<const std::byte> payload, const fuzz::ListedDatagram& datagram) {
    Datagram message;
    const std::uint64_t before = hub_.counts().received;
    const PeerEvent event =
        hub_.handle_datagram(payload, fuzz::address_of_node(datagram.node()), clock_.now_ns(), message, datagram.role());
    fuzz::require(hub_.counts().received == before + 1);
    while (hub_.drop_timed_out(clock_.now_ns()).kind != PeerEvent::Kind::none) {
    }
    if (event.kind == PeerEvent::Kind::none || event.kind == PeerEvent::Kind::rejected) return;
    const Peer& peer = hub_.peer(event.peer);
    fuzz::require(peer.key_role == datagram.role() && event.role == peer.role && event.role == allowed_role(datagram.role()));
    if (event.kind == PeerEvent::Kind::message) check(message, datagram.role());
  }

  static void check(const Datagram& message, KeyRole role) {
    if (const auto* force = std::get_if<ForceCommand>(&message.message)) {
      fuzz::require(role == KeyRole::haptics && force->force_n.allFinite() && force->visual_offset_m.allFinite());
    }
    if (std::holds_alternative<Settings>(message.message)) fuzz::require(role == KeyRole::tool || role == KeyRole::operator_role);
  }

  void to_node(std::span<const std::byte> payload) {
    endpoint_.hold(payload);
    Datagram message;
    if (!client_.receive(message, clock_.now_ns())) return;
    fuzz::require(client_.state() == JoinState::joined && message.header.session == client_.session());
    if (const auto* state = std::get_if<DeviceState>(&message.message)) {
      fuzz::require(state->p_WD.allFinite() && state->p_WP.allFinite() &&
                    std::abs(state->q_WT.norm() - 1.0) <= 1e-3);  // as accepted by the codec
    }
  }

  SimulatedClock clock_{1000 * kNanosecondsPerSecond};
  OnePayloadEndpoint endpoint_;
  HubPeers hub_{endpoint_, clock_, kHubSession, 1000.0};
  HubClient client_{endpoint_, clock_, NodeRole::haptics, fuzz::address_of_hub(), 1};
  std::array<SealedChannel, kNodes> at_hub_;
  std::array<SealedChannel, kNodes> at_node_;
};

}  // namespace
}  // namespace hapton

FUZZ_TARGET(sealed) {
  using namespace hapton;
  fuzz::require(fuzz::FixedRandom::install());
  fuzz::FixedRandom::restart();
  Sessions sessions;
  bool all_opened = true;
  const auto datagrams = fuzz::split_datagrams(bytes);
  for (const fuzz::ListedDatagram& datagram : datagrams) all_opened = sessions.deliver(datagram) && all_opened;
  if (all_opened && !datagrams.empty()) fuzz::note_passage();
}

FUZZ_MUTATOR(sealed, hapton::fuzz::mutate_sealed);
FUZZ_CROSSOVER(sealed, hapton::fuzz::cross_sealed);
