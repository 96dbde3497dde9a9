#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "link/endpoint.h"
#include "link/seal_counts.h"

namespace hapton {

// The layout of sealed datagrams, as in docs/formats.md. Numbers are little-endian.
//
//   lead     08 VERSION KIND 00
//   request  lead  role:1 000000  host:8  timestamp:8  first:48  cookie:16  tag:16   node -> hub
//   retry    lead  timestamp:8  cookie:16  tag:16                                    hub -> node
//   reply    lead  timestamp:8  second:52  tag:16                                    hub -> node
//   data     lead  connection:4  counter:8  ciphertext:n  tag:16                     both directions
//
// The first two bytes of the lead are field 1 of an Envelope (proto/hapton.proto), so that every version recognises the others. The
// cookie of a request is zero until the hub has sent one. `first` and `second` are the two messages of the Noise handshake (noise.h); its
// prologue is the request up to `first`. Retry and reply repeat the timestamp of their request.
namespace seal {

enum class Kind : std::uint8_t { request = 1, retry = 2, reply = 3, data = 4 };

constexpr std::size_t kCookieBytes = 16;
constexpr std::size_t kTagBytes = 16;

using Cookie = std::array<std::uint8_t, kCookieBytes>;

constexpr std::size_t kFirstBytes = 48;   // a public key, the tag of an empty payload
constexpr std::size_t kSecondBytes = 52;  // a public key, the encrypted connection number

constexpr std::size_t kLeadBytes = 4;
constexpr std::size_t kRoleAt = kLeadBytes;
constexpr std::size_t kHostAt = kRoleAt + 4;
constexpr std::size_t kRequestTimestampAt = kHostAt + 8;
constexpr std::size_t kFirstAt = kRequestTimestampAt + 8;
constexpr std::size_t kPrologueBytes = kFirstAt;
constexpr std::size_t kRequestCookieAt = kFirstAt + kFirstBytes;
constexpr std::size_t kRequestTagAt = kRequestCookieAt + kCookieBytes;
constexpr std::size_t kRequestBytes = kRequestTagAt + kTagBytes;

constexpr std::size_t kTimestampAt = kLeadBytes;  // in a retry and in a reply
constexpr std::size_t kCookieAt = kTimestampAt + 8;
constexpr std::size_t kRetryTagAt = kCookieAt + kCookieBytes;
constexpr std::size_t kRetryBytes = kRetryTagAt + kTagBytes;
constexpr std::size_t kSecondAt = kTimestampAt + 8;
constexpr std::size_t kReplyTagAt = kSecondAt + kSecondBytes;
constexpr std::size_t kReplyBytes = kReplyTagAt + kTagBytes;

constexpr std::size_t kConnectionAt = kLeadBytes;
constexpr std::size_t kCounterAt = kConnectionAt + 4;
constexpr std::size_t kHeaderBytes = kCounterAt + 8;

// No reply is longer than its request.
static_assert(kReplyBytes <= kRequestBytes && kRetryBytes <= kRequestBytes);

// The overhead of sealing, and the payload that remains.
constexpr std::size_t kOverheadBytes = kHeaderBytes + kTagBytes;
constexpr std::size_t kMaxPayloadBytes = kMaxDatagramBytes - kOverheadBytes;

template <class Number>
Number load(const std::uint8_t* from) noexcept {
  Number number = 0;
  std::memcpy(&number, from, sizeof number);  // x86 is little-endian
  return number;
}

template <class Number>
void store(Number number, std::uint8_t* into) noexcept {
  std::memcpy(into, &number, sizeof number);
}

inline const std::uint8_t* bytes_of(std::span<const std::byte> span) noexcept { return reinterpret_cast<const std::uint8_t*>(span.data()); }
inline std::uint8_t* bytes_of(std::span<std::byte> span) noexcept { return reinterpret_cast<std::uint8_t*>(span.data()); }

// Writes the first kLeadBytes of a datagram of this kind.
void write_lead(Kind kind, std::uint8_t* into) noexcept;

}  // namespace seal

enum class OpenStatus : std::uint8_t {
  opened,
  malformed,        // not a sealed datagram
  wrong_version,    // sealed with another protocol version
  unknown_session,  // sealed in another session
  replayed,         // seen before, or too old to check
  forged,           // not from the other side of this session
};

void count(OpenStatus status, SealCounts& counts) noexcept;

// The kind that a datagram claims to be.
struct SealedKind {
  OpenStatus status = OpenStatus::malformed;  // opened: it has our version and the length of its kind; else malformed or wrong_version
  seal::Kind kind = seal::Kind::data;
};
SealedKind classify_sealed(std::span<const std::byte> datagram) noexcept;

}  // namespace hapton
