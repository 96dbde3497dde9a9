#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "link/address.h"

namespace hapton {

// Why a sealed endpoint rejected a datagram. Each has its own counter in SealCounts.
enum class Rejection : std::uint8_t {
  malformed,            // of an unknown kind or length
  wrong_version,        // of another protocol version
  wrong_key,            // a handshake without the key of its role
  replayed_handshake,   // a handshake that is no later than one seen before
  too_many_handshakes,  // a valid handshake above the rate limit or the capacity for handshakes
  no_slot,              // a valid handshake, and no free slot
  unknown_session,      // for an unknown session, or from another address than its own
  replayed,             // seen before, or too old to check
  forged,               // for a known session, and not by its peer
  oversized,            // longer than any datagram of ours, or empty
};
constexpr std::size_t kRejections = 10;

// Names the kind of a flood: "datagrams of another protocol version".
std::string_view describe(Rejection rejection) noexcept;

// A flood of rejected datagrams.
struct Flood {
  Rejection rejection = Rejection::malformed;
  Address from;                     // sender of the newest datagram
  bool is_from_several = false;     // from other addresses as well
  double per_second = 0.0;          // including those that the kernel filtered
  bool is_mostly_filtered = false;  // most of it was dropped in the kernel
};

// Detects floods: reports rejections above is_flood_above once a second, the most frequent kind only.
// RT: yes; note costs a few stores and reads no clock. Threads: one.
class RejectionMonitor {
 public:
  static constexpr std::int64_t kEveryNs = 1'000'000'000;

  // Most rejections of this kind a second that are still harmless. Our nodes repeat no handshake and send 20 requests a second, so few of
  // those are already an attack; after a restart a hub gets for a second what its nodes send in the previous session.
  static constexpr double is_flood_above(Rejection rejection) noexcept {
    return rejection == Rejection::replayed_handshake || rejection == Rejection::too_many_handshakes ? 50.0 : 1000.0;
  }

  void note(Rejection rejection, const Address& from, std::uint64_t count = 1) noexcept {
    NotedRejections& of_kind = rejections_[static_cast<std::size_t>(rejection)];
    of_kind.is_from_several = of_kind.is_from_several || (of_kind.count != 0 && of_kind.from != from);
    of_kind.from = from;
    of_kind.count += count;
  }

  // Adds rejections that the kernel dropped at random, unseen: each kind gets its share of them, as among the noted ones.
  void note_filtered(std::uint64_t count) noexcept { filtered_ += count; }

  // Call it at least once a second; more often does no harm.
  std::optional<Flood> take(std::int64_t now_ns) noexcept;

 private:
  struct NotedRejections {
    std::uint64_t count = 0;
    Address from;
    bool is_from_several = false;
  };
  std::array<NotedRejections, kRejections> rejections_ = {};
  std::uint64_t filtered_ = 0;
  std::int64_t since_ns_ = 0;
  bool has_begun_ = false;
};

}  // namespace hapton
