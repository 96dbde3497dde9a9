#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "link/codec.h"
#include "link/datagram_tap.h"
#include "link/endpoint.h"
#include "link/kind_order.h"
#include "link/messages.h"
#include "link/sequence_tracker.h"
#include "runtime/clock.h"

namespace hapton {

// One node that has joined the hub.
struct Peer {
  bool present = false;
  NodeRole role = NodeRole::tool;
  KeyRole key_role = KeyRole::unsealed;
  Address address;
  std::uint64_t sender = 0;  // its Header::sender
  std::int64_t joined_ns = 0;
  std::int64_t last_received_ns = 0;  // hub's clock
  std::uint64_t sent = 0;             // datagrams to it: the last sequence number used
  std::uint64_t send_failures = 0;
  SequenceTracker tracker;  // of datagrams from the peer
  KindOrder order;          // and of the messages in them
};

struct PeerEvent {
  enum class Kind : std::uint8_t {
    none,      // nothing arrived, or it was only counted (heartbeat, unknown peer, malformed)
    message,   // `datagram` holds a message of `peer`
    joined,    // a new peer in slot `peer`; `replaced`: it took the slot of a timed-out or restarted one, without a `left`
    left,      // the peer in slot `peer` sent Bye or timed out; its record stays readable until another takes the slot
    rejected,  // a second haptics node, or no free slot
  };
  Kind kind = Kind::none;
  NodeRole role = NodeRole::tool;
  std::size_t peer = 0;  // slot in the table
  bool replaced = false;
  Arrival arrival = Arrival::newest;  // of a message: newest, or reordered behind one of its kind; duplicates are dropped here
  std::int64_t receive_time_ns = 0;
};

struct HubCounts {
  std::uint64_t received = 0;  // datagrams of any kind
  std::uint64_t undecodable = 0;
  std::uint64_t wrong_version = 0;    // of these, those of another protocol version
  std::uint64_t views_rejected = 0;   // of these, a peer's ViewTransform that was not rigid: it got a ViewRejected
  std::uint64_t other_session = 0;    // a message for an earlier session of the hub
  std::uint64_t unknown_peers = 0;    // a message from a node that has not joined, or not from this address; an invalid Hello
  std::uint64_t wrong_role = 0;       // a message that this role does not send (a vision node's ForceCommand)
  std::uint64_t role_violations = 0;  // a Hello for a role, or a datagram of a peer, that the key it was sealed with does not allow
  std::uint64_t rejections = 0;
  std::uint64_t timeouts = 0;  // peers that timed out
};

// The hub's connections to the nodes: who has joined, and the exchange of messages with them. Any number of vision and tool nodes up to the
// capacity, and one haptics node: a second is rejected while the first is alive; the slot is free 50 ms after its last datagram (or as
// set_haptics_timeout_ns says), or after a Bye.
// A peer is limited to what the key of its session allows: it joins as the role of that key (an operator as a tool), and sends what that
// role sends. One slot is reserved for the haptics node, and an address (host and port) holds at most one of the others, so that a program
// that joins again and again takes no more than one. RT: yes, except construction. Threads: one.
class HubPeers {
 public:
  static constexpr std::size_t kCapacity = 16;  // slot 0 is the haptics node's
  static constexpr std::size_t kHapticsSlot = 0;
  // More than two command timeouts; a node that is started again is back in contact within 200 ms (decision 20).
  static constexpr std::int64_t kHapticsTimeoutNs = 50 * kNanosecondsPerMillisecond;
  static constexpr std::int64_t kPeerTimeoutNs = 1000 * kNanosecondsPerMillisecond;

  // Pre: endpoint and clock outlive this. session: make_random_id().
  HubPeers(Endpoint& endpoint, const Clock& clock, std::uint64_t session, double servo_rate_hz);
  // Sends Bye to every peer.
  ~HubPeers();
  HubPeers(const HubPeers&) = delete;
  HubPeers& operator=(const HubPeers&) = delete;

  // Waits for one datagram until the clock has reached deadline_ns, and handles it. Kind::none may come before the deadline.
  PeerEvent receive(Datagram& datagram, std::int64_t deadline_ns) noexcept;

  // See Endpoint::prepare_wait.
  void prepare_wait(std::int64_t deadline_ns) noexcept { endpoint_.prepare_wait(deadline_ns); }

  // Handles a datagram that was received elsewhere, just as receive does. Post: `datagram` holds the decoded message, if there is one.
  PeerEvent handle_datagram(std::span<const std::byte> bytes, const Address& from, std::int64_t now_ns, Datagram& datagram,
                            KeyRole key_role = KeyRole::unsealed) noexcept;

  // Drops one peer that has timed out; call it until Kind::none. receive does so itself.
  PeerEvent drop_timed_out(std::int64_t now_ns) noexcept;

  // Sends to every peer of this role; returns the number of peers reached.
  std::size_t send_to_role(NodeRole role, const Message& message) noexcept;
  bool send_to(std::size_t peer, const Message& message) noexcept;

  // The tap gets a copy of every datagram from now on; null: no tap. Pre: it outlives this.
  void set_tap(DatagramTap* tap) noexcept { tap_ = tap; }

  // How long the haptics node may be silent until another may take its slot: longer for a time in which it has less to send.
  void set_haptics_timeout_ns(std::int64_t timeout_ns) noexcept { haptics_timeout_ns_ = timeout_ns; }
  std::int64_t haptics_timeout_ns() const noexcept { return haptics_timeout_ns_; }

  // The rate that Welcome reports from now on.
  void set_servo_rate_hz(double servo_rate_hz) noexcept { servo_rate_hz_ = servo_rate_hz; }

  const Peer& peer(std::size_t slot) const noexcept { return peers_[slot]; }
  std::size_t count(NodeRole role) const noexcept;
  bool has_haptics() const noexcept { return peers_[kHapticsSlot].present; }
  std::uint64_t session() const noexcept { return session_; }
  const HubCounts& counts() const noexcept { return counts_; }
  // All zero if the endpoint does not seal.
  SealCounts seal_counts() const noexcept { return endpoint_.seal_counts(); }
  // See Endpoint::take_flood.
  std::optional<Flood> take_flood(std::int64_t now_ns) noexcept { return endpoint_.take_flood(now_ns); }

 private:
  PeerEvent welcome(const Header& header, NodeRole role, const Address& from, std::int64_t now_ns, KeyRole key_role) noexcept;
  PeerEvent reject(const Address& to, NodeRole role, std::int64_t now_ns) noexcept;
  PeerEvent join(std::size_t slot, const Header& header, NodeRole role, const Address& from, std::int64_t now_ns) noexcept;
  PeerEvent leave(std::size_t slot, std::int64_t now_ns) noexcept;
  void reject_view(const Datagram& datagram, const Address& from, std::int64_t now_ns, KeyRole key_role) noexcept;
  PeerEvent accept_message(const Datagram& datagram, const Address& from, std::int64_t now_ns, KeyRole key_role) noexcept;
  std::size_t find(std::uint64_t sender) const noexcept;
  std::size_t find_slot(NodeRole role, const Address& from, std::int64_t now_ns) const noexcept;
  bool transmit(const Address& to, std::uint64_t sequence, const Message& message, std::int64_t now_ns) noexcept;

  Endpoint& endpoint_;
  const Clock& clock_;
  std::uint64_t session_;
  std::uint64_t sender_;
  std::int64_t haptics_timeout_ns_ = kHapticsTimeoutNs;
  double servo_rate_hz_;
  Codec codec_;
  DatagramTap* tap_ = nullptr;
  Datagram outgoing_;
  std::array<std::byte, kMaxDatagramBytes> buffer_ = {};
  std::array<Peer, kCapacity> peers_ = {};
  std::uint64_t rejection_sequence_ = 0;
  std::uint64_t sent_to_replaced_ = 0;  // the largest Peer::sent of those that are no longer known
  HubCounts counts_;
};

}  // namespace hapton
