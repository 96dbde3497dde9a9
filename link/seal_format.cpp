#include "link/seal_format.h"

#include "link/codec.h"

namespace hapton {
namespace {

using namespace seal;

constexpr std::uint8_t kVersionTag = 0x08;  // field 1 of an Envelope, a varint

}  // namespace

void seal::write_lead(Kind kind, std::uint8_t* into) noexcept {
  into[0] = kVersionTag;
  into[1] = static_cast<std::uint8_t>(kProtocolVersion);
  into[2] = static_cast<std::uint8_t>(kind);
  into[3] = 0;
}

void count(OpenStatus status, SealCounts& counts) noexcept {
  switch (status) {
    case OpenStatus::opened:
      ++counts.opened;
      return;
    case OpenStatus::malformed:
      ++counts.malformed;
      return;
    case OpenStatus::wrong_version:
      ++counts.wrong_version;
      return;
    case OpenStatus::unknown_session:
      ++counts.unknown_session;
      return;
    case OpenStatus::replayed:
      ++counts.replayed;
      return;
    case OpenStatus::forged:
      ++counts.forged;
      return;
  }
}

SealedKind classify_sealed(std::span<const std::byte> datagram) noexcept {
  const std::uint8_t* const in = bytes_of(datagram);
  if (datagram.size() < 2 || datagram.size() > kMaxDatagramBytes || in[0] != kVersionTag) return {};
  if (in[1] != kProtocolVersion) return {.status = OpenStatus::wrong_version};
  if (datagram.size() < kLeadBytes || in[3] != 0) return {};
  const auto kind = static_cast<Kind>(in[2]);
  const auto fits = [&] {
    switch (kind) {
      case Kind::request:
        return datagram.size() == kRequestBytes && in[kRoleAt + 1] == 0 && in[kRoleAt + 2] == 0 && in[kRoleAt + 3] == 0;
      case Kind::retry:
        return datagram.size() == kRetryBytes;
      case Kind::reply:
        return datagram.size() == kReplyBytes;
      case Kind::data:
        return datagram.size() > kOverheadBytes;
    }
    return false;
  };
  return {.status = fits() ? OpenStatus::opened : OpenStatus::malformed, .kind = kind};
}

}  // namespace hapton
