#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "core/base/result.h"
#include "link/endpoint.h"

namespace hapton {

// The first bytes of a datagram for a bare echo, and of its reply. An echo ignores replies, so that datagrams do not go back and forth for
// ever between two echoes that a forged sender points at each other, or between an echo and a program that returns what it gets.
constexpr std::size_t kEchoMarkBytes = 8;
constexpr std::array<char, kEchoMarkBytes> kEchoRequest = {'h', 'a', 'p', 'e', 'c', 'h', 'o', '?'};
constexpr std::array<char, kEchoMarkBytes> kEchoReply = {'h', 'a', 'p', 'e', 'c', 'h', 'o', '!'};

// A UDP socket that returns every echo request to its sender, as a reply: one blocking recvfrom, one sendto, nothing else. Its round trip
// is the cost of the machine and its network alone, the yardstick for everything that does more. RT: serve_one yes, the rest set-up only.
// Threads: one.
class BareEchoEndpoint {
 public:
  // bind_address as for open_udp_endpoint; without a port, a free one. Error: one line: bad address, port in use, no permission.
  static Result<BareEchoEndpoint> open(std::string_view bind_address);

  ~BareEchoEndpoint();
  BareEchoEndpoint(BareEchoEndpoint&& other) noexcept;
  BareEchoEndpoint& operator=(BareEchoEndpoint&&) = delete;

  // Returns one request, or ignores one other datagram; false if nothing came for 100 ms, so that the caller can check whether to
  // continue.
  bool serve_one() noexcept;

  const Address& local_address() const { return local_; }
  std::uint64_t served() const { return served_; }
  std::uint64_t ignored() const { return ignored_; }  // datagrams that were no echo request

 private:
  BareEchoEndpoint(int socket, const Address& local) : socket_(socket), local_(local) {}

  int socket_ = -1;
  Address local_;
  std::uint64_t served_ = 0;
  std::uint64_t ignored_ = 0;
};

}  // namespace hapton
