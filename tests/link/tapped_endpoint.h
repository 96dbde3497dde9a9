#pragma once

#include <algorithm>
#include <deque>
#include <memory>
#include <utility>
#include <vector>

#include "link/endpoint.h"

namespace hapton {

// An endpoint with an attacker on the wire, who sees all incoming datagrams and injects any datagrams under any address.
class TappedEndpoint final : public Endpoint {
 public:
  struct ArrivedDatagram {
    Address from;
    std::vector<std::byte> bytes;
  };

  explicit TappedEndpoint(std::unique_ptr<Endpoint> endpoint) : endpoint_(std::move(endpoint)) {}

  void inject(const Address& from, std::vector<std::byte> bytes) { injected_.push_back({from, std::move(bytes)}); }
  // All datagrams that were received, except the injected ones.
  const std::vector<ArrivedDatagram>& arrived() const { return arrived_; }
  // Counts as if the socket had skipped this many oversized datagrams.
  void inject_oversized(const Address& from, std::uint64_t count) {
    counts_.last_oversized = from;
    counts_.oversized += count;
  }
  // The number of datagrams that were sent from this endpoint.
  std::size_t sent() const { return sent_; }

  bool send(const Address& to, std::span<const std::byte> datagram) noexcept override {
    ++sent_;
    return endpoint_->send(to, datagram);
  }

  Received receive(std::span<std::byte> into, std::int64_t deadline_ns) noexcept override {
    if (!injected_.empty()) {
      const ArrivedDatagram next = injected_.front();
      injected_.pop_front();
      std::copy(next.bytes.begin(), next.bytes.end(), into.begin());
      return {.bytes = next.bytes.size(), .from = next.from};
    }
    const Received received = endpoint_->receive(into, deadline_ns);
    if (received.bytes != 0) {
      arrived_.push_back({received.from, {into.begin(), into.begin() + static_cast<std::ptrdiff_t>(received.bytes)}});
    }
    return received;
  }

  Address local_address() const override { return endpoint_->local_address(); }
  SocketCounts socket_counts() const noexcept override { return counts_; }
  void expect(const Address& from, std::uint32_t connection) noexcept override { expected_.emplace_back(from, connection); }
  // The addresses and connection numbers from which the hub expects datagrams.
  const std::vector<std::pair<Address, std::uint32_t>>& expected() const { return expected_; }
  // Counts as if a filter in the kernel had dropped this many datagrams.
  void filter(std::uint64_t count) { counts_.filtered += count; }

 private:
  std::unique_ptr<Endpoint> endpoint_;
  std::deque<ArrivedDatagram> injected_;
  std::vector<ArrivedDatagram> arrived_;
  std::size_t sent_ = 0;
  SocketCounts counts_;
  std::vector<std::pair<Address, std::uint32_t>> expected_;
};

}  // namespace hapton
