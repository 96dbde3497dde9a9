#pragma once

#include <cstdint>

#include "link/endpoint.h"
#include "runtime/clock.h"

namespace hapton {

// An endpoint that counts the datagrams that pass through another one, and notes when.
// RT: as the inner endpoint, and a clock reading for each datagram. Threads: as the inner endpoint.
class MeteredEndpoint final : public Endpoint {
 public:
  struct Counts {
    std::uint64_t datagrams_sent = 0;
    std::uint64_t bytes_sent = 0;  // UDP payload
    std::uint64_t datagrams_received = 0;
    std::uint64_t bytes_received = 0;
  };

  // Pre: both outlive this.
  MeteredEndpoint(Endpoint& inner, const Clock& clock) : inner_(inner), clock_(clock) {}

  bool send(const Address& to, std::span<const std::byte> datagram) noexcept override {
    last_send_ns_ = clock_.now_ns();
    const bool is_sent = inner_.send(to, datagram);
    counts_.datagrams_sent += is_sent ? 1 : 0;
    counts_.bytes_sent += is_sent ? datagram.size() : 0;
    return is_sent;
  }

  Received receive(std::span<std::byte> into, std::int64_t deadline_ns) noexcept override {
    const Received received = inner_.receive(into, deadline_ns);
    if (received.bytes > 0) {
      last_receive_ns_ = clock_.now_ns();
      ++counts_.datagrams_received;
      counts_.bytes_received += received.bytes;
    }
    return received;
  }

  void prepare_wait(std::int64_t deadline_ns) noexcept override { inner_.prepare_wait(deadline_ns); }
  Address local_address() const override { return inner_.local_address(); }
  void expect(const Address& from, std::uint32_t connection) noexcept override { inner_.expect(from, connection); }
  SocketCounts socket_counts() const noexcept override { return inner_.socket_counts(); }

  const Counts& counts() const noexcept { return counts_; }
  // When the newest datagram was handed to the system, and when the newest one was taken from it.
  std::int64_t last_send_ns() const noexcept { return last_send_ns_; }
  std::int64_t last_receive_ns() const noexcept { return last_receive_ns_; }

 private:
  Endpoint& inner_;
  const Clock& clock_;
  Counts counts_;
  std::int64_t last_send_ns_ = 0;
  std::int64_t last_receive_ns_ = 0;
};

}  // namespace hapton
