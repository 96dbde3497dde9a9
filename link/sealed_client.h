#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "link/endpoint.h"
#include "link/handshake.h"
#include "link/host_id.h"
#include "link/role_key.h"
#include "link/seal_counts.h"
#include "link/sealed_channel.h"
#include "runtime/clock.h"

namespace hapton {

// A node's sealed connection to its hub. It seals every datagram that it sends and returns only datagrams that it could open. It sets up
// the necessary sessions by itself, within send and receive.
//   silence   If nothing was received from the hub for kPeerTimeoutNs plus the round trip of the handshake, a new session is requested. The
//             old one stays in use until the hub sends in the new one. So a node finds a restarted hub again, and loses nothing if the
//             hub was only slow.
//   rekeying  A session is replaced every rekey_every_ns, and after rekey_after datagrams. Datagrams in the old one stay valid for
//             kOverlapNs after the hub has changed to the new one, so that the change neither loses nor delays any.
// While there is no session, only the newest datagram is kept, and sent once there is one. While the hub is silent and a new session is
// requested, each datagram is sent in the old one, and the newest of them again in the new one, so that it may arrive twice.
// Pre: the user calls send or receive at least every 100 ms, and sends, ten times a second, a message to which the hub replies.
// RT: yes with a worker thread; without one, X25519 runs in the caller (0.1 ms for each request and each session); construction and
// destruction set-up only. Threads: one.
class SealedClient final : public Endpoint {
 public:
  static constexpr std::int64_t kPeerTimeoutNs = 200 * kNanosecondsPerMillisecond;  // two of the hub's replies are missing (Pre)
  static constexpr std::int64_t kMaxTripNs = 2 * kNanosecondsPerSecond;             // the most that the round trip adds to the timeout
  // Between two requests, without a session or with a silent hub: shorter finds a hub sooner, and costs the node more key pairs.
  static constexpr std::int64_t kRequestPeriodNs = 50 * kNanosecondsPerMillisecond;
  // The same for rekeying, which is not urgent: the old session still works.
  static constexpr std::int64_t kRekeyRequestPeriodNs = 250 * kNanosecondsPerMillisecond;
  static constexpr std::int64_t kRekeyEveryNs = 120 * kNanosecondsPerSecond;  // the same as WireGuard's
  // Datagrams: far below the limits of AES-256-GCM, and a bound on how much one key can open. Half an hour at 10 kHz.
  static constexpr std::uint64_t kRekeyAfter = std::uint64_t{1} << 24;
  static constexpr std::int64_t kOverlapNs = kNanosecondsPerSecond;  // a choice: longer than a datagram is under way

  struct Options {
    std::uint64_t host = find_host_id();  // names the clock that timestamps are read from
    AgreementWorker::Where worker = AgreementWorker::Where::caller;
    std::int64_t rekey_every_ns = kRekeyEveryNs;
    std::uint64_t rekey_after = kRekeyAfter;
  };

  // Pre: endpoint and clock outlive this.
  SealedClient(Endpoint& endpoint, const Clock& clock, const RoleKey& key, const Address& hub, const Options& options);
  SealedClient(Endpoint& endpoint, const Clock& clock, const RoleKey& key, const Address& hub)
      : SealedClient(endpoint, clock, key, hub, Options()) {}

  // False: `to` is not the hub, it does not fit (seal::kMaxPayloadBytes), or the system rejected it. True: it may still get lost.
  bool send(const Address& to, std::span<const std::byte> datagram) noexcept override;
  Received receive(std::span<std::byte> into, std::int64_t deadline_ns) noexcept override;
  void prepare_wait(std::int64_t deadline_ns) noexcept override { endpoint_.prepare_wait(deadline_ns); }
  Address local_address() const override { return endpoint_.local_address(); }
  SealCounts seal_counts() const noexcept override;

 private:
  void request_if_due(std::int64_t now_ns) noexcept;
  void request_if_silent(std::int64_t now_ns) noexcept;
  bool is_rekey_due(std::int64_t now_ns) const noexcept;
  bool is_hub_silent(std::int64_t now_ns) const noexcept { return now_ns - last_received_ns_ >= timeout_ns_; }
  void begin(std::int64_t now_ns) noexcept;
  void request(std::int64_t now_ns) noexcept;
  void take_finished() noexcept;
  void change_over() noexcept;
  std::size_t open(std::span<const std::byte> datagram, const Address& from, std::span<std::byte> into) noexcept;
  void receive_handshake(seal::Kind kind, std::span<const std::byte> datagram) noexcept;
  bool transmit(std::span<const std::byte> datagram) noexcept;
  std::int64_t next_due_ns(std::int64_t now_ns) const noexcept;

  Endpoint& endpoint_;
  const Clock& clock_;
  Address hub_;
  Options options_;
  ClientHandshake handshake_;
  SealedChannel channel_;
  SealedChannel previous_;  // the old session: the hub uses it until it has received in the new one, and its datagrams may be late
  std::int64_t previous_ends_ns_ = 0;
  SealCounts counts_;
  std::int64_t next_request_ns_ = 0;
  std::int64_t rekey_ns_ = 0;
  std::int64_t last_received_ns_ = 0;
  std::int64_t timeout_ns_ = kPeerTimeoutNs;
  bool has_received_ = false;  // since last_received_ns_
  bool may_retry_ = false;     // one request in reply to a retry for each regular request
  std::size_t held_bytes_ = 0;
  bool was_held_sent_ = false;  // whether the system accepted what was held when the session began
  std::array<std::byte, kMaxDatagramBytes> held_ = {};
  std::array<std::byte, kMaxDatagramBytes> incoming_ = {};
  std::array<std::byte, kMaxDatagramBytes> outgoing_ = {};
};

}  // namespace hapton
