#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "link/endpoint.h"

namespace hapton {

// Receives a copy of every datagram that a hub exchanges: what it sends, before sealing, and what it receives, after opening. It
// gets no datagram that could not be opened, or that the system refused to send. Units: the hub's clock, ns. RT: yes. Threads: the
// hub's.
class DatagramTap {
 public:
  virtual ~DatagramTap() = default;

  virtual void on_received(const Address& from, std::span<const std::byte> datagram, std::int64_t time_ns) noexcept = 0;
  virtual void on_sent(const Address& to, std::span<const std::byte> datagram, std::int64_t time_ns) noexcept = 0;
};

}  // namespace hapton
