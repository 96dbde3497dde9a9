#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>

#include "runtime/spin_trial.h"

namespace hapton {

// How long the network side spins on its socket for the force of a sample before it sleeps on it. It spins only while SpinTrial finds that
// forces arrive during the spin: a sleeping thread needs 10 to 30 us to wake up. Units: ns. RT: yes. Threads: the network side's; set_limit
// and spun_ns any.
class ReplySpin {
 public:
  // Largest share of a period. The rest is for other threads on this CPU; SchedulingMonitor lowers the limit further.
  static constexpr double kMaxShare = 0.5;

  // longest_ns: the longest spin for one sample; 0: never spins.
  explicit ReplySpin(std::int64_t longest_ns = 0) noexcept : longest_ns_(longest_ns) {}

  // share: the largest share of a period to spend spinning.
  void set_limit(double share) noexcept { limit_.store(share, std::memory_order_relaxed); }

  // Returns the time at which to stop spinning; now_ns: do not spin. Call once for each sample that was sent.
  std::int64_t find_end_ns(std::int64_t now_ns, std::int64_t period_ns) noexcept {
    const auto share_ns = static_cast<std::int64_t>(limit_.load(std::memory_order_relaxed) * static_cast<double>(period_ns));
    const std::int64_t most_ns = std::min(longest_ns_, share_ns);
    return most_ns > 0 && trial_.may_spin() ? now_ns + most_ns : now_ns;
  }
  // Call after each spin. arrived: the force came before the end of the spin.
  void note(bool arrived, std::int64_t spun_ns) noexcept {
    trial_.note(arrived);
    spun_ns_.store(spun_ns_.load(std::memory_order_relaxed) + spun_ns, std::memory_order_relaxed);
  }

  std::int64_t longest_ns() const noexcept { return longest_ns_; }
  // Total time spent spinning.
  std::int64_t spun_ns() const noexcept { return spun_ns_.load(std::memory_order_relaxed); }

 private:
  std::int64_t longest_ns_;
  std::atomic<double> limit_{kMaxShare};
  std::atomic<std::int64_t> spun_ns_{0};
  SpinTrial trial_;
};

}  // namespace hapton
