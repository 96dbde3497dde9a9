#pragma once

#include <algorithm>
#include <cstdint>

#include "link/endpoint.h"
#include "runtime/clock.h"

namespace hapton {

// An endpoint that hands out so many datagrams and then none until its budget is renewed: who asks for more sleeps to the deadline instead.
// So a loop that renews it once a cycle has work of bounded time however much arrives, and always sleeps: it is neither throttled by the
// kernel nor ended by LimitRTTIME. What is not taken waits in the socket's buffer, and is dropped by the kernel when that is full.
// RT: as the other. Threads: as the other.
class BudgetedEndpoint final : public Endpoint {
 public:
  // The shortest sleep of who has spent his budget, when the deadline has passed already.
  static constexpr std::int64_t kShortestSleepNs = 50'000;

  // Pre: both outlive this.
  BudgetedEndpoint(Endpoint& inner, Clock& clock) : inner_(inner), clock_(clock) {}

  void renew(std::uint32_t datagrams) noexcept { left_ = datagrams; }
  // For a loop that had no reason to wait for too long.
  void rest() noexcept { clock_.sleep_until_ns(clock_.now_ns() + kShortestSleepNs); }
  // Times that someone wanted more.
  std::uint64_t spent() const noexcept { return spent_; }

  bool send(const Address& to, std::span<const std::byte> datagram) noexcept override { return inner_.send(to, datagram); }

  Received receive(std::span<std::byte> into, std::int64_t deadline_ns) noexcept override {
    if (left_ == 0) {
      ++spent_;
      clock_.sleep_until_ns(std::max(deadline_ns, clock_.now_ns() + kShortestSleepNs));
      return {};
    }
    const Received received = inner_.receive(into, deadline_ns);
    left_ -= received.bytes > 0 ? 1 : 0;
    return received;
  }

  void prepare_wait(std::int64_t deadline_ns) noexcept override { inner_.prepare_wait(deadline_ns); }
  Address local_address() const override { return inner_.local_address(); }
  void expect(const Address& from, std::uint32_t connection) noexcept override { inner_.expect(from, connection); }
  SocketCounts socket_counts() const noexcept override { return inner_.socket_counts(); }

 private:
  Endpoint& inner_;
  Clock& clock_;
  std::uint32_t left_ = 0xFFFFFFFF;
  std::uint64_t spent_ = 0;
};

}  // namespace hapton
