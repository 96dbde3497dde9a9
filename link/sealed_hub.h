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

// The hub's way to its nodes: each address that has agreed on a session has keys of its own, what is sent to it is sealed with them, and
// nothing is handed out that was not opened with them. Strangers get no answer, take no place and cost a hash at most. Who has the key
// takes a place, and drops another of the same address only once he has proved with a sealed datagram that he is there: a recorded
// handshake is worth nothing. When all places are taken the one that has been silent longest goes, unless it was heard within kIdleNs.
// RT: yes; construction and destruction set-up only. Threads: one.
class SealedHub final : public Endpoint {
 public:
  static constexpr std::size_t kPlaces = 32;     // twice HubPeers::kCapacity: nodes come again before they are missed
  static constexpr std::size_t kCandidates = 8;  // of these, sessions that nothing was heard on yet
  static constexpr std::int64_t kIdleNs = 2 * kNanosecondsPerSecond;

  // Pre: endpoint and clock outlive this.
  SealedHub(Endpoint& endpoint, const Clock& clock, const LinkKey& key);

  // False when nobody at that address has a session, when it does not fit (seal::kMaxPayloadBytes), or when the system refused it.
  bool send(const Address& to, std::span<const std::byte> datagram) noexcept override;
  Received receive(std::span<std::byte> into, std::int64_t deadline_ns) noexcept override;
  void prepare_wait(std::int64_t deadline_ns) noexcept override { endpoint_.prepare_wait(deadline_ns); }
  Address local_address() const override { return endpoint_.local_address(); }
  SealCounts seal_counts() const noexcept override { return counts_; }

 private:
  enum class State : std::uint8_t { free, candidate, live };

  struct Session {
    State state = State::free;
    Address address;
    std::int64_t last_heard_ns = 0;  // of a candidate: when it was agreed on
    SealedChannel channel;
    seal::Nonce client_nonce = {};
    std::array<std::byte, seal::kAnswerBytes> answer = {};  // the same again to who repeats his request
  };

  std::size_t open(std::span<const std::byte> datagram, const Address& from, std::span<std::byte> into) noexcept;
  void promote(Session& session) noexcept;
  void hear_request(std::span<const std::byte> request, const Address& from) noexcept;
  void agree(const seal::Nonce& client_nonce, const Address& from, std::int64_t now_ns) noexcept;
  Session* find_live(const Address& address) noexcept;
  Session* find_agreed(const seal::Nonce& client_nonce, const Address& address) noexcept;
  Session* find_place(std::int64_t now_ns) noexcept;

  Endpoint& endpoint_;
  const Clock& clock_;
  HubHandshake handshake_;
  std::array<Session, kPlaces> sessions_ = {};
  std::size_t last_place_ = 0;    // sent to last
  std::uint32_t generation_ = 0;  // in the upper bits of a connection's number, its place in the lower
  SealCounts counts_;
  std::array<std::byte, kMaxDatagramBytes> incoming_ = {};
  std::array<std::byte, kMaxDatagramBytes> outgoing_ = {};
};

}  // namespace hapton
