#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "link/endpoint.h"
#include "link/key_schedule.h"
#include "link/link_key.h"
#include "link/seal_format.h"
#include "link/sealed_channel.h"

namespace hapton {

// How two holders of a key agree on a session, without sockets, clocks or threads of their own:
//
//   node                                        hub
//   request(nonce, no cookie)          ---->    knows the key? then a cookie for this address and nonce; keeps nothing
//                                      <----    retry(nonce, cookie)
//   request(nonce, cookie)             ---->    cookie good? then a place, a nonce that was never used before, session keys
//                                      <----    answer(connection, hub's nonce)
//   data sealed with the session keys  ---->    first one opened: the session lives, and replaces an older one from this address
//
// Every message carries a tag under the shared key; what has none is not answered. A node that hears nothing repeats its request.

// The node's side of one attempt after another. RT: yes; begin makes one system call, for random bytes. Threads: one.
class ClientHandshake {
 public:
  enum class Heard : std::uint8_t {
    nothing,    // not for this attempt, or its seal does not hold
    cookie,     // a request with it is now the thing to send
    agreement,  // take_channel() is a session
  };

  explicit ClientHandshake(const LinkKey& key);
  ~ClientHandshake();
  ClientHandshake(const ClientHandshake&) = delete;
  ClientHandshake& operator=(const ClientHandshake&) = delete;

  // A new attempt; the one before is forgotten.
  void begin() noexcept;
  bool is_pending() const noexcept { return is_pending_; }

  // The request to send, in `into`. Pre: is_pending(), into holds seal::kRequestBytes.
  std::size_t write_request(std::span<std::byte> into) const noexcept;

  // Pre: the datagram is a retry or an answer by its kind and length.
  Heard read(seal::Kind kind, std::span<const std::byte> datagram) noexcept;

  // The session that was agreed on; once.
  SealedChannel take_channel() noexcept { return std::move(channel_); }

 private:
  Heard read_retry(const std::uint8_t* in) noexcept;
  Heard read_answer(std::span<const std::byte> datagram) noexcept;

  LinkKey key_;
  seal::Secret handshake_key_;
  seal::Nonce nonce_ = {};
  seal::Cookie cookie_ = {};
  bool is_pending_ = false;
  SealedChannel channel_;
};

// The hub's side. It holds no state about anyone: who keeps a session once it has been agreed on is SealedHub's business.
// RT: yes; construction set-up only. Threads: one.
class HubHandshake {
 public:
  // How long a cookie is good for: at least one such time, at most two.
  static constexpr std::int64_t kCookieTimeNs = 2'000'000'000;

  enum class Verdict : std::uint8_t {
    stranger,      // made without the key
    wants_cookie,  // write_retry is the answer
    shows_cookie,  // may have a session
  };

  explicit HubHandshake(const LinkKey& key);
  ~HubHandshake();
  HubHandshake(const HubHandshake&) = delete;
  HubHandshake& operator=(const HubHandshake&) = delete;

  // Pre: the datagram is a request by its kind and length.
  Verdict judge(std::span<const std::byte> request, const Address& from, std::int64_t now_ns) const noexcept;
  static seal::Nonce nonce_of(std::span<const std::byte> request) noexcept;

  // Pre: into holds seal::kRequestBytes.
  std::size_t write_retry(const seal::Nonce& client_nonce, const Address& to, std::int64_t now_ns,
                          std::span<std::byte> into) const noexcept;

  // A session of its own for every call, whatever the request. Pre: into holds seal::kAnswerBytes.
  SealedChannel agree(const seal::Nonce& client_nonce, std::uint32_t connection, std::span<std::byte> into) noexcept;

 private:
  seal::Cookie make_cookie(const seal::Nonce& client_nonce, const Address& to, std::int64_t period) const noexcept;

  LinkKey key_;
  seal::Secret handshake_key_;
  seal::Secret secret_;  // this hub's own, of this start
  std::uint64_t sessions_ = 0;
};

}  // namespace hapton
