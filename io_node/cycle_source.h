#pragma once

#include <cstdint>

#include "io_node/device_loop.h"
#include "io_node/hub_receiver.h"
#include "link/budgeted_endpoint.h"
#include "link/hub_peers.h"
#include "runtime/clock.h"

namespace hapton {

// Cycle timing of the network side: waits for the device side's next cycle and receives datagrams meanwhile. The device side has
// its own thread, or (tests on simulated time) runs its cycles here. While the device side computes the forces itself, it does not wait
// for the network side, which then rests for several cycles and reads them together: that saves most of its CPU time at high rates.
// Units: ns of the hub's clock. RT: yes. Threads: the network side's.
class CycleSource {
 public:
  // How long to spin for a cycle of the device side that is due: it runs on another CPU, or its thread preempts this one.
  static constexpr std::int64_t kLongestSpinNs = 50'000;
  // Largest number of datagrams handled in a millisecond (but 32 in each wait are always handled): at 1 us each they take three tenths of
  // the time. It is twenty times the number that 16 nodes send.
  static constexpr std::int64_t kDatagramsPerMs = 300;

  // Pre: all outlive this.
  CycleSource(DeviceLoop& loop, HubReceiver& receiver, HubPeers& peers, const Clock& clock) noexcept
      : loop_(loop), receiver_(receiver), peers_(peers), clock_(clock) {
    receiver_.set_device_loop(&loop_);
  }

  // Set up before start.
  void set_budget(BudgetedEndpoint* budget) noexcept { budget_ = budget; }
  void use_device_thread() noexcept {
    has_device_thread_ = true;
    receiver_.set_device_loop(nullptr);
  }
  bool has_device_thread() const noexcept { return has_device_thread_; }

  // Waits for a cycle. last: the newest one taken. rest_ns: how long after its tick this side may rest; not above a period: it waits only
  // for the next cycle. False: there is no cycle yet; the caller does its other work and calls again.
  bool await(const DeviceCycle& last, double rate_hz, std::int64_t rest_ns = 0) noexcept;

  // Sets the timers of the next two waits. To be called when no force is due, since setting a timer takes microseconds. A rest needs no
  // timer, as it may end a little late.
  void prepare_next_wait(const DeviceCycle& cycle, std::int64_t rest_ns = 0) noexcept;

 private:
  static bool rests(const DeviceCycle& last, std::int64_t rest_ns) noexcept { return rest_ns > last.next_tick_ns - last.tick_ns; }
  void renew_budget(std::int64_t period_ns) noexcept;
  void run_device_cycle() noexcept;
  bool await_device_thread(const DeviceCycle& last) noexcept;

  DeviceLoop& loop_;
  HubReceiver& receiver_;
  HubPeers& peers_;
  const Clock& clock_;
  BudgetedEndpoint* budget_ = nullptr;
  bool has_device_thread_ = false;
  std::uint32_t cycles_behind_ = 0;
};

}  // namespace hapton
