#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "core/base/result.h"
#include "link/endpoint.h"

namespace hapton {

// How a datagram for a bare echo begins, and how it comes back. An echo passes over what has come back once already: two of them that are
// told of each other by a forged sender do not go on for ever, nor does one with another program that returns what it gets.
constexpr std::size_t kEchoMarkBytes = 8;
constexpr std::array<char, kEchoMarkBytes> kEchoRequest = {'h', 'a', 'p', 'e', 'c', 'h', 'o', '?'};
constexpr std::array<char, kEchoMarkBytes> kEchoReply = {'h', 'a', 'p', 'e', 'c', 'h', 'o', '!'};

// A UDP socket that returns every echo request to its sender, as a reply: one blocking recvfrom, one sendto, nothing else. Its round trip
// is what the machine and its network cost by themselves, the measure for everything that does more. RT: serve_one yes, the rest set-up
// only. Threads: one.
class BareEchoEndpoint {
 public:
  // bind_address as for open_udp_endpoint. Error: one line: bad address, port in use, no permission.
  static Result<BareEchoEndpoint> open(std::string_view bind_address);

  ~BareEchoEndpoint();
  BareEchoEndpoint(BareEchoEndpoint&& other) noexcept;
  BareEchoEndpoint& operator=(BareEchoEndpoint&&) = delete;

  // Returns one request, or passes over one datagram that is none; false when nothing came for 100 ms, so that the caller can look whether
  // to go on.
  bool serve_one() noexcept;

  const Address& local_address() const { return local_; }
  std::uint64_t served() const { return served_; }
  std::uint64_t passed_over() const { return passed_over_; }

 private:
  BareEchoEndpoint(int socket, const Address& local) : socket_(socket), local_(local) {}

  int socket_ = -1;
  Address local_;
  std::uint64_t served_ = 0;
  std::uint64_t passed_over_ = 0;
};

}  // namespace hapton
