#pragma once

#include <array>
#include <cstdint>

namespace hapton {

// Where a datagram goes to or came from: IPv4 or IPv6 address and port.
struct Address {
  std::array<std::uint8_t, 16> ip = {};  // IPv4 is held v4-mapped (::ffff:a.b.c.d)
  std::uint16_t port = 0;
  friend bool operator==(const Address&, const Address&) = default;
};

}  // namespace hapton
