#pragma once

#include <algorithm>
#include <cstdint>

#include "link/endpoint.h"
#include "runtime/clock.h"

namespace hapton {

// An endpoint that hands out a limited number of datagrams until its budget is renewed; further calls of receive() sleep until their
// deadline. A loop that renews it once a cycle has bounded work however much arrives, and always sleeps, so the kernel neither throttles it
// nor ends it by LimitRTTIME. Datagrams not taken wait in the socket's buffer, and the kernel drops more when that is full. RT and threads:
// as the inner endpoint.
class BudgetedEndpoint final : public Endpoint {
 public:
  // The shortest sleep of receive() with a spent budget, used if the deadline is nearer than this or has passed. A choice: long enough for
  // the kernel to run another thread, and a twentieth of a cycle at 1 kHz.
  static constexpr std::int64_t kShortestSleepNs = 50'000;

  // Pre: both outlive this.
  BudgetedEndpoint(Endpoint& inner, Clock& clock) : inner_(inner), clock_(clock) {}

  void renew(std::uint32_t datagrams) noexcept { datagrams_left_ = datagrams; }
  // Sleeps for kShortestSleepNs: for a loop that has found work waiting for too many cycles in a row.
  void rest() noexcept { clock_.sleep_until_ns(clock_.now_ns() + kShortestSleepNs); }
  // Number of calls of receive() with a spent budget.
  std::uint64_t spent() const noexcept { return waits_without_budget_; }

  bool send(const Address& to, std::span<const std::byte> datagram) noexcept override { return inner_.send(to, datagram); }

  Received receive(std::span<std::byte> into, std::int64_t deadline_ns) noexcept override {
    if (datagrams_left_ == 0) {
      ++waits_without_budget_;
      clock_.sleep_until_ns(std::max(deadline_ns, clock_.now_ns() + kShortestSleepNs));
      return {};
    }
    const Received received = inner_.receive(into, deadline_ns);
    datagrams_left_ -= received.bytes > 0 ? 1 : 0;
    return received;
  }

  void prepare_wait(std::int64_t deadline_ns) noexcept override { inner_.prepare_wait(deadline_ns); }
  Address local_address() const override { return inner_.local_address(); }
  void expect(const Address& from, std::uint32_t connection) noexcept override { inner_.expect(from, connection); }
  SocketCounts socket_counts() const noexcept override { return inner_.socket_counts(); }

 private:
  Endpoint& inner_;
  Clock& clock_;
  std::uint32_t datagrams_left_ = 0xFFFFFFFF;
  std::uint64_t waits_without_budget_ = 0;
};

}  // namespace hapton
