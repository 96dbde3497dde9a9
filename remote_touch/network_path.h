#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "link/fault_injector.h"

namespace hapton {

// Counts the datagrams that were sent, including lost ones.
struct Traffic {
  std::uint64_t packets = 0;
  std::uint64_t bytes = 0;  // size of their IP packets

  Traffic operator+(const Traffic& more) const noexcept { return {packets + more.packets, bytes + more.bytes}; }
  Traffic operator-(const Traffic& before) const noexcept { return {packets - before.packets, bytes - before.bytes}; }
};

// One direction of a network in simulated time: datagrams arrive late, in another order, twice or never. Units: ns. RT: no. Threads: one.
template <class Payload>
class NetworkPath {
 public:
  NetworkPath(const LinkFaults& faults, std::uint64_t seed) : injector_(seed) { injector_.set(faults); }

  void send(const Payload& payload, std::size_t bytes, std::int64_t now_ns) {
    ++traffic_.packets;
    traffic_.bytes += bytes;
    const Fate fate = injector_.draw(now_ns);
    if (fate.kind != Fate::Kind::passed) return;
    for (std::size_t copy = 0; copy < fate.copies; ++copy) {
      in_flight_.push_back({fate.due_ns[copy], ++order_, payload});
      std::push_heap(in_flight_.begin(), in_flight_.end(), is_later);
    }
  }

  // The next datagram that is due: the earliest one, and of several at the same time the one sent first.
  std::optional<Payload> receive(std::int64_t now_ns) {
    if (in_flight_.empty() || in_flight_.front().due_ns > now_ns) return std::nullopt;
    std::pop_heap(in_flight_.begin(), in_flight_.end(), is_later);
    std::optional<Payload> payload(std::move(in_flight_.back().payload));
    in_flight_.pop_back();
    return payload;
  }

  const Traffic& traffic() const noexcept { return traffic_; }

 private:
  struct Item {
    std::int64_t due_ns = 0;
    std::uint64_t order = 0;
    Payload payload;
  };
  static bool is_later(const Item& a, const Item& b) noexcept { return a.due_ns != b.due_ns ? a.due_ns > b.due_ns : a.order > b.order; }

  FaultInjector injector_;
  std::vector<Item> in_flight_;  // a heap, the next one first
  std::uint64_t order_ = 0;
  Traffic traffic_;
};

}  // namespace hapton
