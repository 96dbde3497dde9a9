#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "core/math/rigid_pose.h"
#include "link/messages.h"

namespace hapton {

// The version in every datagram; a receiver drops datagrams of another version. The rules of change are in proto/hapton.proto.
constexpr std::uint32_t kProtocolVersion = 3;

// Lengths (m) and forces (N) beyond this are rejected, so that squares and products of accepted ones stay finite.
constexpr double kMaxWireMagnitude = kMaxTranslationM;

// Times beyond this, before or after zero, are rejected: sums and differences of three accepted ones fit into 64 bits. This is 73 years,
// which no clock that counts from start-up reaches.
constexpr std::int64_t kMaxWireTimeNs = (std::int64_t{1} << 61) - 1;

enum class DecodeStatus : std::uint8_t {
  ok,
  truncated,        // ends early, or is not a well-formed Envelope
  wrong_version,    // of another protocol version
  unknown_message,  // well formed, of this version, of a kind this build does not know
  bad_value,        // too long, not finite, out of range, a vector of the wrong length, not a rotation, two messages in one
  not_rigid,        // a ViewTransform that is valid except for its pose (core/math/rigid_pose.h)
};

std::string_view to_string(DecodeStatus status) noexcept;

// Turns datagrams into bytes and back as proto/hapton.proto specifies. It keeps its protobuf objects between calls: one Codec for each
// thread. RT: encode and decode yes (no heap, lock or throw, whatever the bytes); construction set-up only.
class Codec {
 public:
  Codec();
  ~Codec();
  Codec(Codec&&) noexcept;
  Codec& operator=(Codec&&) noexcept;

  // Writes the datagram into `into` and returns its size; 0: it does not fit. It does not check values: decode does.
  std::size_t encode(const Datagram& datagram, std::span<std::byte> into) noexcept;

  // Reads one datagram. Post: after ok, `datagram` is what was read. After not_rigid, it holds the header and a ViewTransform of the
  // received revision with the identity pose, so that the receiver can report the rejection to the sender. After all others it is
  // unchanged.
  DecodeStatus decode(std::span<const std::byte> bytes, Datagram& datagram) noexcept;

 private:
  struct Wire;
  std::unique_ptr<Wire> wire_;
};

}  // namespace hapton
