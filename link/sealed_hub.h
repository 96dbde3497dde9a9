#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "link/endpoint.h"
#include "link/handshake.h"
#include "link/link_key.h"
#include "link/rate_limit.h"
#include "link/rejection_monitor.h"
#include "link/seal_counts.h"
#include "link/sealed_channel.h"
#include "runtime/clock.h"

namespace hapton {

// The hub's sealed connections to its nodes: each address that has agreed on a session has its own keys; datagrams to it are sealed with
// them, and receive() returns only datagrams that they open.
//   rejection  A sender without a key gets no reply and no slot; its datagram costs a check of four bytes, or a hash. The same applies to
//              a recorded handshake that is sent again: its time must be later than all others of its host and role
//              (handshake_times.h). Each rejection is counted, and the worst flood of them is reported (take_flood).
//   rates      Retries and agreements are limited by source address and in all: 64 and 256 a second, for each role separately.
//   X25519     A worker computes agreements. The caller passes it requests that have shown key, time and address, and sends each reply in
//              a later call, when it is finished. A full worker drops requests; it never makes the caller wait.
//   candidates A request from an address that got a reply lately gets no reply, because that reply may still be under way. The next reply
//              comes kReplyEveryNs later at the earliest, the one after it twice that, and so on to kMaxReplyEveryNs: a node whose reply
//              was lost soon gets another, and a node that is a second away finds its session when its first datagram arrives. While all
//              slots for candidates are taken, an address that has a reply gets no other for kReplyLivesNs.
//   sessions   A new session of the same role and address replaces the old one once a datagram was opened in it. Datagrams of the old one
//              are opened for another kOverlapNs, unless the new one is replaced, too, so that none under way is lost. Each role has its
//              own slots (kRoleSlots), at most half of them for sessions in which nothing was opened yet: the holder of one role's key
//              cannot keep another role out. When no slot is free, the session that has been silent longest, for more than kIdleNs, is
//              dropped; if there is none, the oldest in which nothing was opened yet; if there is none either, the request is rejected.
// RT: yes with a worker thread; construction and destruction set-up only. Threads: one.
class SealedHub final : public Endpoint {
 public:
  static constexpr std::size_t kSlots = 64;  // four times HubPeers::kCapacity: old and new sessions, and nodes that come again
  static constexpr std::array<std::size_t, kNodeKeyRoles> kRoleSlots = {8, 24, 24, 8};  // for haptics, vision, tool, operator
  static constexpr std::int64_t kIdleNs = 2 * kNanosecondsPerSecond;
  static constexpr std::int64_t kOverlapNs = kNanosecondsPerSecond;
  static constexpr std::int64_t kReplyEveryNs = 100 * kNanosecondsPerMillisecond;
  static constexpr std::int64_t kMaxReplyEveryNs = 8 * kReplyEveryNs;
  static constexpr std::int64_t kReplyLivesNs = 2 * kNanosecondsPerSecond;
  static constexpr SourceLimit::Rates kHandshakeRates = {
      .source_per_second = 64, .source_burst = 32, .all_per_second = 256, .all_burst = 64};

  // Pre: endpoint and clock outlive this.
  SealedHub(Endpoint& endpoint, const Clock& clock, const LinkKey& master, AgreementWorker::Where worker = AgreementWorker::Where::caller);

  // False if there is no session with that address, if the datagram does not fit (seal::kMaxPayloadBytes), or if the system rejected it.
  bool send(const Address& to, std::span<const std::byte> datagram) noexcept override;
  // Received::role is the role of the session's key.
  Received receive(std::span<std::byte> into, std::int64_t deadline_ns) noexcept override;
  void prepare_wait(std::int64_t deadline_ns) noexcept override { endpoint_.prepare_wait(deadline_ns); }
  Address local_address() const override { return endpoint_.local_address(); }
  SealCounts seal_counts() const noexcept override;
  std::optional<Flood> take_flood(std::int64_t now_ns) noexcept override;

 private:
  enum class State : std::uint8_t {
    free,
    agreeing,   // the worker computes its keys
    candidate,  // replied to; nothing has been opened in it yet
    live,
    retiring,  // replaced: its datagrams are opened until ends_ns
  };

  struct Session {
    State state = State::free;
    KeyRole role = KeyRole::unsealed;
    Address address;
    std::uint32_t connection = 0;
    std::int64_t last_received_ns = 0;  // before it was live: when it was requested
    std::int64_t ends_ns = 0;           // end of a retiring session
    SealedChannel channel;
  };

  std::size_t open(std::span<const std::byte> datagram, const Address& from, std::span<std::byte> into, KeyRole& role) noexcept;
  void reject(Rejection rejection, const Address& from) noexcept;
  void promote(Session& session) noexcept;
  void receive_request(std::span<const std::byte> request, const Address& from) noexcept;
  void retry(std::span<const std::byte> request, const Address& from, std::int64_t now_ns) noexcept;
  void agree(std::span<const std::byte> request, const Address& from, std::int64_t now_ns) noexcept;
  void take_agreements() noexcept;
  Session* find_live(const Address& address) noexcept;
  static std::span<Session> slots_of(KeyRole role, std::array<Session, kSlots>& sessions) noexcept;
  static std::size_t max_candidates(std::span<const Session> slots) noexcept { return slots.size() / 2; }
  bool had_reply_lately(const Address& address, KeyRole role, std::int64_t now_ns) noexcept;
  static Session* find_slot(std::span<Session> slots, std::int64_t now_ns) noexcept;
  bool is_taken_by_another_role(const Address& address, KeyRole role, std::int64_t now_ns) const noexcept;

  Endpoint& endpoint_;
  const Clock& clock_;
  HubHandshake handshake_;
  std::array<SourceLimit, kNodeKeyRoles> retry_limits_;  // by role
  std::array<SourceLimit, kNodeKeyRoles> agreement_limits_;
  RejectionMonitor rejection_monitor_;
  std::uint64_t oversized_noted_ = 0;
  std::uint64_t filtered_noted_ = 0;
  std::array<Session, kSlots> sessions_ = {};
  std::array<std::uint8_t, 16> hints_ = {};  // slot that was last sent to, by the lower bits of the port
  std::uint32_t generation_ = 0;             // the upper bits of a connection's number; the lower ones are its slot
  SealCounts counts_;
  std::array<std::byte, kMaxDatagramBytes> incoming_ = {};
  std::array<std::byte, kMaxDatagramBytes> outgoing_ = {};
};

}  // namespace hapton
