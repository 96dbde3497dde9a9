#pragma once

#include <array>
#include <cstdint>

#include "link/codec.h"
#include "link/endpoint.h"
#include "link/kind_order.h"
#include "link/messages.h"
#include "link/sequence_tracker.h"
#include "runtime/clock.h"

namespace hapton {

enum class JoinState : std::uint8_t {
  joining,   // no hub has replied yet, or it has left or timed out (kHubTimeoutNs)
  rejected,  // the hub replied that it has no slot: another haptics node holds it, or all are taken; Hello goes on
  joined,
};

struct ClientCounts {
  std::uint64_t sent = 0;
  std::uint64_t send_failures = 0;  // messages that the system rejected, or that were given to send() while not joined
  std::uint64_t received = 0;       // messages handed to the caller
  std::uint64_t undecodable = 0;    // datagrams that Codec rejects
  std::uint64_t wrong_version = 0;  // of these, those of another protocol version: the hub is another build
  std::uint64_t foreign = 0;        // not from the hub's address
  std::uint64_t other_session = 0;  // from an earlier session of the hub, or before this node joined
  std::uint64_t joins = 0;          // 2 or more: the hub restarted, left or was silent, or this node was rejected for a while
};

// A node's connection to the hub (haptics, vision, tool). It joins by itself, sends Hello every 100 ms, joins again when the hub restarts,
// and sends Bye at the end. All of this happens within send and receive: call one of them at least every 100 ms. RT: send and receive yes;
// construction and destruction set-up only. Threads: one.
class HubClient {
 public:
  // A tenth of HubPeers::kPeerTimeoutNs: nine Hellos in succession may be lost. If five get no reply, the hub is gone.
  static constexpr std::int64_t kHelloPeriodNs = 100 * kNanosecondsPerMillisecond;
  static constexpr std::int64_t kHubTimeoutNs = 500 * kNanosecondsPerMillisecond;

  // Pre: endpoint and clock outlive the client. sender_id 0: a random one.
  HubClient(Endpoint& endpoint, const Clock& clock, NodeRole role, const Address& hub, std::uint64_t sender_id = 0);
  ~HubClient();
  // Sends Bye now, ahead of destruction. Afterwards only the counters may be read: call neither send nor receive.
  void leave() noexcept;
  HubClient(const HubClient&) = delete;
  HubClient& operator=(const HubClient&) = delete;

  // Sends to the hub, even if it is silent; false (and counted) before joining, after rejection or Bye, or when the system rejects.
  bool send(const Message& message) noexcept;

  // Waits until a message from the hub has arrived or the clock has reached deadline_ns; false in the latter case. Welcome and Bye are
  // handled internally. A deadline in the past only takes what has already come: call again until false to drain to the newest. Duplicates
  // are dropped; a message that a newer one of its kind overtook is returned, and last_arrival() reports that, so that the caller can keep
  // the newest.
  bool receive(Datagram& out, std::int64_t deadline_ns) noexcept;

  // Arrival time and order of the message that receive() returned last.
  std::int64_t receive_time_ns() const noexcept { return receive_time_ns_; }
  Arrival last_arrival() const noexcept { return last_arrival_; }

  JoinState state() const noexcept;
  // The hub's last session ended with its Bye, not with a timeout; false again when joined.
  bool has_hub_left() const noexcept { return has_hub_left_; }
  // The hub's servo rate as of its last Welcome; 0 before the first.
  double servo_rate_hz() const noexcept { return servo_rate_hz_; }
  std::uint64_t session() const noexcept { return session_; }
  const ClientCounts& counts() const noexcept { return counts_; }
  const SequenceCounts& sequence_counts() const noexcept { return tracker_.counts(); }

 private:
  bool transmit(const Message& message, std::int64_t now_ns) noexcept;
  void say_hello_if_due(std::int64_t now_ns) noexcept;
  bool accept(const Datagram& datagram, std::int64_t now_ns) noexcept;
  void accept_welcome(const Header& header, const Welcome& welcome, std::int64_t now_ns) noexcept;

  Endpoint& endpoint_;
  const Clock& clock_;
  NodeRole role_;
  Address hub_;
  std::uint64_t sender_;
  Codec codec_;
  Datagram outgoing_;
  std::array<std::byte, kMaxDatagramBytes> buffer_ = {};
  SequenceTracker tracker_;
  KindOrder order_;
  ClientCounts counts_;
  JoinState state_ = JoinState::joining;
  Arrival last_arrival_ = Arrival::newest;
  std::uint64_t session_ = 0;
  std::uint64_t retired_session_ = 0;  // the session before: a late Welcome in it is ignored
  std::int64_t accepted_at_ns_ = 0;    // of the hub's clock: when it sent the newest Welcome that accepts this node
  std::uint64_t sequence_ = 0;
  std::int64_t next_hello_ns_ = 0;
  std::int64_t last_received_ns_ = 0;
  std::int64_t receive_time_ns_ = 0;
  double servo_rate_hz_ = 0.0;
  bool has_hub_left_ = false;
};

}  // namespace hapton
