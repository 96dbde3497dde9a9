#pragma once

#include <cstdint>

namespace hapton {

// Counters of the sealed datagrams that one side accepted and rejected. A rejected datagram gets no reply.
struct SealCounts {
  std::uint64_t opened = 0;
  std::uint64_t handshakes = 0;           // sessions that both sides have agreed on
  std::uint64_t retries = 0;              // cookies sent to nodes that had shown their key but not their address
  std::uint64_t repeats = 0;              // valid handshakes without a reply, because an earlier reply may still be under way; not rejected
  std::uint64_t malformed = 0;            // datagrams of an unknown kind or length
  std::uint64_t wrong_version = 0;        // datagrams of another protocol version
  std::uint64_t wrong_key = 0;            // handshakes without the key of their role
  std::uint64_t replayed_handshakes = 0;  // handshakes no later than one seen before
  std::uint64_t too_many_handshakes = 0;  // valid handshakes above the rate limit, or beyond the capacity for handshakes
  std::uint64_t unknown_session = 0;      // for an unknown session, or from another address than its own
  std::uint64_t replayed = 0;             // seen before, or too old to check
  std::uint64_t forged = 0;               // for an existing session, but not from its peer
  std::uint64_t no_slot = 0;              // valid handshakes that found no free slot, or whose address is in use by another role
  std::uint64_t oversized = 0;            // longer than kMaxDatagramBytes, or empty

  std::uint64_t rejected() const {
    return malformed + wrong_version + wrong_key + replayed_handshakes + too_many_handshakes + unknown_session + replayed + forged +
           no_slot + oversized;
  }
};

}  // namespace hapton
