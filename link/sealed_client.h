#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "link/endpoint.h"
#include "link/handshake.h"
#include "link/link_key.h"
#include "link/seal_counts.h"
#include "link/sealed_channel.h"
#include "runtime/clock.h"

namespace hapton {

// A node's way to its hub: what it sends is sealed, what it receives was opened, and the session that this takes is agreed on by itself,
// within send and receive. When the hub has been silent for kSilenceNs it is asked for a new session, while the old one stays in use until
// the hub speaks in the new one: a hub that restarts is found again, and one that was only slow has lost nothing.
// Datagrams sent while no session is agreed on are held, the newest of them, and sent with it; one sent while a new session is awaited
// goes both ways, so that it may arrive twice.
// Pre: whoever uses it calls send or receive at least every 100 ms, and says ten times a second what the hub answers.
// RT: yes; construction and destruction set-up only. Threads: one.
class SealedClient final : public Endpoint {
 public:
  static constexpr std::int64_t kSilenceNs = 200 * kNanosecondsPerMillisecond;
  static constexpr std::int64_t kRequestPeriodNs = 50 * kNanosecondsPerMillisecond;

  // Pre: endpoint and clock outlive this.
  SealedClient(Endpoint& endpoint, const Clock& clock, const LinkKey& key, const Address& hub);

  // To the hub only; false when it does not fit (seal::kMaxPayloadBytes) or the system refused it. True says nothing of its arrival.
  bool send(const Address& to, std::span<const std::byte> datagram) noexcept override;
  Received receive(std::span<std::byte> into, std::int64_t deadline_ns) noexcept override;
  void prepare_wait(std::int64_t deadline_ns) noexcept override { endpoint_.prepare_wait(deadline_ns); }
  Address local_address() const override { return endpoint_.local_address(); }
  SealCounts seal_counts() const noexcept override { return counts_; }

 private:
  void ask_if_due(std::int64_t now_ns) noexcept;
  void ask_if_silent(std::int64_t now_ns) noexcept;
  void begin(std::int64_t now_ns) noexcept;
  void ask() noexcept;
  std::size_t open(std::span<const std::byte> datagram, const Address& from, std::span<std::byte> into) noexcept;
  void hear_handshake(seal::Kind kind, std::span<const std::byte> datagram) noexcept;
  bool transmit(std::span<const std::byte> datagram) noexcept;
  std::int64_t next_due_ns() const noexcept;

  Endpoint& endpoint_;
  const Clock& clock_;
  Address hub_;
  ClientHandshake handshake_;
  SealedChannel channel_;
  SealedChannel previous_;  // the hub's words still come in it until it has heard us in the new one
  SealCounts counts_;
  std::int64_t next_request_ns_ = 0;
  std::int64_t last_heard_ns_ = 0;
  bool has_heard_ = false;  // since last_heard_ns_
  bool may_retry_ = false;  // one answer to a retry for each request sent in its time
  std::size_t held_bytes_ = 0;
  std::array<std::byte, kMaxDatagramBytes> held_ = {};
  std::array<std::byte, kMaxDatagramBytes> incoming_ = {};
  std::array<std::byte, kMaxDatagramBytes> outgoing_ = {};
};

}  // namespace hapton
