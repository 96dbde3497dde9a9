#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "link/address.h"
#include "link/key_role.h"
#include "runtime/clock.h"
#include "tests/fuzz/mutation.h"

namespace hapton::fuzz {

// One datagram of an input: flags (1 byte), length (2 bytes, little-endian), the datagram.
struct ListedDatagram {
  std::uint8_t flags = 0;
  Bytes bytes;

  // Bit 0 is set: from the hub to the node. It is clear: from a node to the hub.
  bool is_to_node() const { return (flags & 1U) != 0; }
  // Bits 1 and 2 select one of four nodes. Each has the key of its role and its own address.
  std::uint8_t node() const { return (flags >> 1) & 3U; }
  KeyRole role() const { return static_cast<KeyRole>(kFirstKeyRole + node()); }
  // Bits 3 and 4 select the pause after the previous datagram.
  std::int64_t pause_ns() const {
    constexpr std::int64_t kPauses[] = {0, 1, 60, 1100};
    return kPauses[(flags >> 3) & 3U] * kNanosecondsPerMillisecond;
  }
};

// The last datagram may be shorter than its length says. Datagrams longer than kMaxDatagramBytes are kept at their length.
std::vector<ListedDatagram> split_datagrams(std::span<const std::uint8_t> input);
Bytes join_datagrams(const std::vector<ListedDatagram>& datagrams);

std::span<const std::byte> as_datagram(const Bytes& bytes);
Address address_of_node(std::uint8_t node);
Address address_of_hub();

}  // namespace hapton::fuzz
