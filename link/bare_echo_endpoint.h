#pragma once

#include <cstdint>
#include <string_view>

#include "core/base/result.h"
#include "link/endpoint.h"

namespace hapton {

// A UDP socket that returns every datagram to its sender: one blocking recvfrom, one sendto, nothing else. Its round trip is what the
// machine and its network cost by themselves, the measure for everything that does more.
// RT: serve_one yes, the rest set-up only. Threads: one.
class BareEchoEndpoint {
 public:
  // bind_address as for open_udp_endpoint. Error: one line: bad address, port in use, no permission.
  static Result<BareEchoEndpoint> open(std::string_view bind_address);

  ~BareEchoEndpoint();
  BareEchoEndpoint(BareEchoEndpoint&& other) noexcept;
  BareEchoEndpoint& operator=(BareEchoEndpoint&&) = delete;

  // Returns one datagram; false when none came for 100 ms, so that the caller can look whether to go on.
  bool serve_one() noexcept;

  const Address& local_address() const { return local_; }
  std::uint64_t served() const { return served_; }

 private:
  BareEchoEndpoint(int socket, const Address& local) : socket_(socket), local_(local) {}

  int socket_ = -1;
  Address local_;
  std::uint64_t served_ = 0;
};

}  // namespace hapton
