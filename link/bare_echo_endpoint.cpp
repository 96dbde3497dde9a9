#include "link/bare_echo_endpoint.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "link/address_endpoint.h"

namespace hapton {

Result<BareEchoEndpoint> BareEchoEndpoint::open(std::string_view bind_address) {
  const auto address = parse_address(bind_address, 0);
  if (!address) {
    return tl::unexpected(address.error());
  }
  const int socket = ::socket(address_family(*address), SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket < 0) {
    return fail("echo: no socket for {}: {}", bind_address, std::strerror(errno));
  }
  BareEchoEndpoint echo(socket, *address);
  const SocketAddress local = to_socket_address(*address);
  if (::bind(socket, local.get(), local.size) != 0) {
    const char* const remedy = errno == EADDRNOTAVAIL ? "use an address of this host" : "choose another port, or 0 for a free one";
    return fail("echo: cannot bind {}: {}; {}", bind_address, std::strerror(errno), remedy);
  }
  const timeval timeout = {.tv_sec = 0, .tv_usec = 100'000};
  if (::setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof timeout) != 0) {
    return fail("echo: cannot set a time limit on {}: {}", bind_address, std::strerror(errno));
  }
  echo.local_.port = hapton::local_address(socket).port;
  return echo;
}

BareEchoEndpoint::BareEchoEndpoint(BareEchoEndpoint&& other) noexcept
    : socket_(std::exchange(other.socket_, -1)), local_(other.local_), served_(other.served_), ignored_(other.ignored_) {}

BareEchoEndpoint::~BareEchoEndpoint() {
  if (socket_ >= 0) {
    ::close(socket_);
  }
}

bool BareEchoEndpoint::serve_one() noexcept {
  std::array<std::byte, 65536> buffer;
  SocketAddress from;
  const ssize_t received = ::recvfrom(socket_, buffer.data(), buffer.size(), 0, from.get(), &from.size);
  if (received < 0) {
    return false;
  }
  if (static_cast<std::size_t>(received) < kEchoMarkBytes || std::memcmp(buffer.data(), kEchoRequest.data(), kEchoMarkBytes) != 0) {
    ++ignored_;
    return true;
  }
  std::memcpy(buffer.data(), kEchoReply.data(), kEchoMarkBytes);
  ::sendto(socket_, buffer.data(), static_cast<std::size_t>(received), 0, from.get(), from.size);
  ++served_;
  return true;
}

}  // namespace hapton
