#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "link/endpoint.h"
#include "link/seal_counts.h"

namespace hapton {

// What sealed datagrams look like; docs/formats.md says the same in words. Numbers are little-endian.
//
//   lead     08 VERSION KIND 00   the first two bytes are field 1 of an Envelope (proto/hapton.proto): any version knows another by them
//   request  lead  client_nonce:32  cookie:16  tag:16            node -> hub; the cookie is zero until the hub has given one
//   retry    lead  client_nonce:32  cookie:16  tag:16            hub -> node
//   answer   lead  connection:4  hub_nonce:32  tag:16            hub -> node
//   data     lead  connection:4  counter:8  ciphertext:n tag:16  either way
namespace seal {

enum class Kind : std::uint8_t { request = 1, retry = 2, answer = 3, data = 4 };

constexpr std::size_t kNonceBytes = 32;
constexpr std::size_t kCookieBytes = 16;
constexpr std::size_t kTagBytes = 16;

using Nonce = std::array<std::uint8_t, kNonceBytes>;
using Cookie = std::array<std::uint8_t, kCookieBytes>;

constexpr std::size_t kLeadBytes = 4;
constexpr std::size_t kNonceAt = kLeadBytes;
constexpr std::size_t kCookieAt = kNonceAt + kNonceBytes;
constexpr std::size_t kRequestTagAt = kCookieAt + kCookieBytes;
constexpr std::size_t kRequestBytes = kRequestTagAt + kTagBytes;
constexpr std::size_t kConnectionAt = kLeadBytes;
constexpr std::size_t kHubNonceAt = kConnectionAt + 4;
constexpr std::size_t kAnswerTagAt = kHubNonceAt + kNonceBytes;
constexpr std::size_t kAnswerBytes = kAnswerTagAt + kTagBytes;
constexpr std::size_t kCounterAt = kConnectionAt + 4;
constexpr std::size_t kHeaderBytes = kCounterAt + 8;

// Nobody is sent more than he has sent.
static_assert(kAnswerBytes <= kRequestBytes);

// What sealing adds to a datagram, and what then is left for what it carries.
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

// The first kLeadBytes of a datagram of this kind.
void write_lead(Kind kind, std::uint8_t* into) noexcept;

}  // namespace seal

enum class OpenStatus : std::uint8_t {
  opened,
  malformed,        // no sealed datagram at all
  wrong_version,    // of another protocol version
  unknown_session,  // of another session
  replayed,         // seen before, or too old to tell
  forged,           // not by the other side of this session
};

void count(OpenStatus status, SealCounts& counts) noexcept;

// What a datagram says that it is.
struct SealedKind {
  OpenStatus status = OpenStatus::malformed;  // opened: one of our version, with the length of its kind; else malformed or wrong_version
  seal::Kind kind = seal::Kind::data;
};
SealedKind classify_sealed(std::span<const std::byte> datagram) noexcept;

}  // namespace hapton
