#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace hapton {

// io_node's default port.
constexpr std::uint16_t kDefaultHubPort = 4950;

// Where a datagram goes to or came from: IPv4 or IPv6 address and port.
struct Address {
  std::array<std::uint8_t, 16> ip = {};  // IPv4 is held v4-mapped (::ffff:a.b.c.d)
  std::uint16_t port = 0;
  friend bool operator==(const Address&, const Address&) = default;
};

// RT: both yes.
bool is_v4(const Address& address) noexcept;
bool is_loopback(const Address& address) noexcept;

// The address to bind a socket for `peer`: any address of its family, any port. RT: yes.
std::string_view any_address_like(const Address& peer) noexcept;

// "host:port", "host", "1.2.3.4:port", "[2001:db8::1]:port" or a bare IPv6 address; without a port, default_port. Host names are resolved,
// IPv4 first. A number alone is rejected, because it could be a port or an address. RT: no. Error: one line with the text and what is wrong
// with it.
Result<Address> parse_address(std::string_view text, std::uint16_t default_port = kDefaultHubPort);

// "127.0.0.1:4950" or "[::1]:4950": what parse_address reads back. RT: no.
std::string to_string(const Address& address);

}  // namespace hapton
