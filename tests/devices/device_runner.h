#pragma once

#include <algorithm>
#include <utility>

#include "devices/device.h"
#include "runtime/clock.h"
#include "tests/support/allocation_guard.h"

namespace hapton {

// Runs a device as the device loop does, in real time, until a condition holds or half a minute is over.
class DeviceRunner {
 public:
  static constexpr std::int64_t kPatienceNs = 30 * kNanosecondsPerSecond;

  template <class Condition>
  bool serve_until(Device& device, Condition&& holds, const Wrench& wrench = {}) {
    std::int64_t before_ns = clock_.now_ns();
    longest_gap_ns_ = 0;
    return wait_until([&] {
      const std::int64_t now_ns = clock_.now_ns();
      longest_gap_ns_ = std::max(longest_gap_ns_, now_ns - std::exchange(before_ns, now_ns));
      sample_ = device.read(now_ns);
      device.write(wrench, now_ns);
      return holds();
    });
  }

  template <class Condition>
  static bool wait_until(Condition&& holds) {
    SteadyClock clock;
    const std::int64_t end_ns = clock.now_ns() + kPatienceNs;
    while (!holds()) {
      if (clock.now_ns() > end_ns) return false;
      clock.sleep_until_ns(clock.now_ns() + kNanosecondsPerMillisecond);
    }
    return true;
  }

  // Heap allocations of a thousand cycles. Pre: AllocationGuard::is_available().
  static std::uint64_t count_heap_use(Device& device) {
    const AllocationGuard guard;
    for (std::int64_t t = 0; t < 1000; ++t) {
      device.read(t);
      device.write({.force_n = Vec3(0, 0, 1)}, t);
      (void)device.status();
      (void)device.condition();
    }
    return guard.count();
  }

  const DeviceSample& sample() const { return sample_; }
  // The longest time between two commands of the last serve_until: on a busy machine this thread may have to wait for the CPU.
  std::int64_t longest_gap_ns() const { return longest_gap_ns_; }

 private:
  SteadyClock clock_;
  DeviceSample sample_;
  std::int64_t longest_gap_ns_ = 0;
};

}  // namespace hapton
