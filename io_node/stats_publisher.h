#pragma once

#include <atomic>

#include "core/base/mailbox.h"
#include "io_node/device_loop.h"
#include "io_node/servo_stats.h"

namespace hapton {

// Hands a copy of ServoStats to another thread on request.
// RT: yes. Threads: the network side's calls publish_if_requested, one other the rest.
class StatsPublisher {
 public:
  // The other thread: requests a copy, and takes it when it is there (within a few cycles).
  void request() noexcept { is_requested_.store(true, std::memory_order_release); }
  bool take() noexcept { return copies_.take(); }
  const ServoStats& copy() const noexcept { return copies_.value(); }

  // The network side calls this once a cycle. A device side in a thread of its own sends its part with its next cycle. fill(device_stats)
  // returns the complete statistics.
  template <class Fill>
  void publish_if_requested(DeviceLoop& loop, bool has_device_thread, Fill&& fill) noexcept {
    if (is_requested_.exchange(false, std::memory_order_acq_rel)) {
      is_due_ = true;
      if (has_device_thread) return loop.request_stats();
    }
    if (!is_due_ || (has_device_thread && !loop.take_stats())) return;
    is_due_ = false;
    copies_.publish(fill(has_device_thread ? loop.stats_copy() : loop.collect_stats()));
  }

 private:
  Mailbox<ServoStats> copies_;
  std::atomic<bool> is_requested_{false};
  bool is_due_ = false;
};

}  // namespace hapton
