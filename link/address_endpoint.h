#pragma once

#include <netinet/in.h>
#include <sys/socket.h>

#include <boost/asio/ip/address.hpp>

#include "link/address.h"

namespace hapton {

// An address in the form that system calls take.
struct SocketAddress {
  sockaddr_storage storage = {};
  socklen_t size = sizeof(sockaddr_storage);
  sockaddr* get() { return reinterpret_cast<sockaddr*>(&storage); }
  const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&storage); }
};

// RT: all yes. An IPv4 address becomes AF_INET, every other AF_INET6.
int address_family(const Address& address) noexcept;
SocketAddress to_socket_address(const Address& address) noexcept;
// AF_INET6 for every address, as a socket of that family sends to IPv4 too.
SocketAddress to_v6_socket_address(const Address& address) noexcept;
// Pre: AF_INET or AF_INET6.
Address from_socket_address(const SocketAddress& address) noexcept;
// The address that a socket is bound to; port 0 if the system does not report it.
Address local_address(int socket) noexcept;

// The same for Boost.Asio.
boost::asio::ip::address to_asio(const Address& address) noexcept;
Address from_asio(const boost::asio::ip::address& ip, std::uint16_t port) noexcept;
// Endpoint: boost::asio::ip::udp::endpoint or tcp::endpoint.
template <class Endpoint>
Endpoint to_endpoint(const Address& address) noexcept {
  return Endpoint(to_asio(address), address.port);
}
template <class Endpoint>
Address from_endpoint(const Endpoint& endpoint) noexcept {
  return from_asio(endpoint.address(), endpoint.port());
}

}  // namespace hapton
