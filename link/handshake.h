#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>

#include "link/agreement_worker.h"
#include "link/endpoint.h"
#include "link/handshake_times.h"
#include "link/key_schedule.h"
#include "link/link_key.h"
#include "link/seal_format.h"
#include "link/sealed_channel.h"

namespace hapton {

// How a node and the hub agree on a session, without sockets, clocks or loops of their own: the Noise handshake of noise.h, with the psk of
// the node's role, behind checks that cost the hub a hash:
//
//   node                                                          hub
//   request(role, host, timestamp, first, no cookie)     ---->    key of the role? later than all before? then a cookie for this address
//                                               <----    retry(timestamp, cookie)
//   request(role, host, timestamp, first, cookie)        ---->    cookie good? then a slot, and the worker replies
//                                               <----    reply(timestamp, second)
//   data sealed with the session keys           ---->    first one opened: the session lives
//
// Every message carries a tag under a key of the role; a message without a valid tag gets no reply. A node that receives no reply sends
// another request, with a new timestamp and a new key pair.

// The node's side of handshakes: one attempt after another until a session is agreed on.
// RT: as its worker; begin makes no system call. Threads: one.
class ClientHandshake {
 public:
  // Newest requests whose reply is still accepted. One is sent every 50 ms, and one more for each retry: enough for a round trip of 1.6 s.
  static constexpr std::size_t kAttempts = 64;

  enum class Finished : std::uint8_t {
    nothing,
    request,    // the datagram is in `into`
    agreement,  // take_channel() returns the new session
  };

  // host: find_host_id(), the same for all nodes that read one CLOCK_MONOTONIC.
  ClientHandshake(const RoleKey& key, std::uint64_t host, AgreementWorker::Where where);
  ~ClientHandshake();
  ClientHandshake(const ClientHandshake&) = delete;
  ClientHandshake& operator=(const ClientHandshake&) = delete;

  // Begins a new handshake; the one before is forgotten.
  void begin() noexcept;
  bool is_pending() const noexcept { return is_pending_; }

  // Starts to make a request, which poll() returns later. False if the worker has no room. Pre: is_pending().
  bool start_request(std::int64_t now_ns) noexcept;
  // The worker has a task, or a result to take: call poll() soon.
  bool is_working() const noexcept { return worker_.pending_count() != 0; }

  // Takes the next result of the worker; call it until there is none. Pre: into holds seal::kRequestBytes.
  Finished poll(std::span<std::byte> into) noexcept;

  // True if it was valid and, for a reply, the worker had room for it; also for the same reply again, which is ignored. Pre: its kind and
  // length are those of a retry, or of a reply.
  bool read_retry(std::span<const std::byte> retry) noexcept;
  bool read_reply(std::span<const std::byte> reply) noexcept;

  // Timestamp of the request that the newest valid reply replies to. Pre: there was such a reply.
  std::int64_t replied_request_ns() const noexcept { return replied_request_ns_; }

  // Hands over the session that was agreed on. Call it once, after Finished::agreement.
  SealedChannel take_channel() noexcept { return std::move(channel_); }

 private:
  struct Attempt {
    std::int64_t timestamp_ns = 0;
    bool is_open = false;  // sent, without a reply
    noise::HandshakeState state;
  };

  void write_prologue(std::int64_t timestamp_ns, std::uint8_t* into) const noexcept;
  void write_request(const AgreementTask& task, std::uint8_t* out) noexcept;
  Attempt* find_attempt(std::int64_t timestamp_ns) noexcept;
  void forget_attempts() noexcept;

  KeyRole role_;
  seal::Secret handshake_key_;
  seal::Secret psk_;
  std::uint64_t host_;
  AgreementWorker worker_;
  std::array<Attempt, kAttempts> attempts_ = {};
  std::size_t next_attempt_ = 0;
  std::uint32_t handshake_number_ = 0;  // number of the handshake: results for earlier ones are dropped
  std::int64_t last_timestamp_ns_ = 0;
  std::int64_t replied_request_ns_ = 0;
  seal::Cookie cookie_ = {};
  bool is_pending_ = false;
  SealedChannel channel_;
};

// The hub's side of handshakes. SealedHub keeps the sessions.
// RT: as its worker; construction set-up only. Threads: one.
class HubHandshake {
 public:
  // A cookie is valid for at least this time, and at most twice as long. ns.
  static constexpr std::int64_t kCookieTimeNs = 2'000'000'000;

  enum class Verdict : std::uint8_t {
    malformed,     // its role is unknown
    wrong_key,     // made without the key of that role
    replayed,      // no later than one that was seen before
    wants_cookie,  // write_retry makes the reply
    shows_cookie,  // its cookie is valid: it may have a session
  };

  // A handshake that the worker has finished.
  struct Agreement {
    std::uint32_t connection = 0;
    bool is_valid = false;  // false: the request was made without the psk, in spite of its valid tag
    std::array<std::byte, seal::kReplyBytes> reply = {};
    SealedChannel channel;
  };

  HubHandshake(const LinkKey& master, AgreementWorker::Where where);
  ~HubHandshake();
  HubHandshake(const HubHandshake&) = delete;
  HubHandshake& operator=(const HubHandshake&) = delete;

  // Checks a request. One that is newer than all before of its role and host is remembered, so that it is accepted only once. Pre: the kind
  // and length of the datagram are those of a request.
  Verdict check_request(std::span<const std::byte> request, const Address& from, std::int64_t now_ns) noexcept;
  // Pre: check_request did not return malformed.
  static KeyRole role_of(std::span<const std::byte> request) noexcept;

  // Pre: check_request returned wants_cookie; into holds seal::kRetryBytes.
  std::size_t write_retry(std::span<const std::byte> request, const Address& to, std::int64_t now_ns,
                          std::span<std::byte> into) const noexcept;

  // Starts to agree on a session with this connection number. False if the worker has no room. Pre: check_request returned shows_cookie.
  bool agree(std::span<const std::byte> request, std::uint32_t connection) noexcept;
  bool is_working() const noexcept { return worker_.pending_count() != 0; }
  // Takes the next finished handshake; false if there is none.
  bool poll(Agreement& agreement) noexcept;

 private:
  seal::Cookie make_cookie(const Address& to, std::int64_t period) const noexcept;
  const seal::Secret& handshake_key(KeyRole role) const noexcept { return keys_[static_cast<std::size_t>(role) - kFirstKeyRole].handshake; }

  struct RoleKeys {
    seal::Secret handshake = {};
    seal::Secret psk = {};
  };
  std::array<RoleKeys, kNodeKeyRoles> keys_ = {};
  seal::Secret secret_;  // key of the cookies, random at each start of the hub
  HandshakeTimes times_;
  AgreementWorker worker_;
};

}  // namespace hapton
