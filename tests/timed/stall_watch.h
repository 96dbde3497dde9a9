#pragma once

#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

namespace hapton {

// Measures how long this machine stood still: on each CPU a thread of the highest real-time priority (an ordinary one where the user may
// not have that) looks at the clock every millisecond. What it misses, every program on that CPU missed, whatever its priority: a
// hypervisor ran something else. Units: ns. Threads: any.
class StallWatch {
 public:
  // A force may be as old as that (docs/safety-case.md): who stalls for longer must let go of it, and a test sees that.
  static constexpr std::int64_t kForceLifeNs = 20'000'000;

  StallWatch();
  ~StallWatch();
  StallWatch(const StallWatch&) = delete;
  StallWatch& operator=(const StallWatch&) = delete;

  // The longest time since construction or restart() that a thread came too late.
  std::int64_t longest_ns() const { return longest_ns_.load(); }
  void restart() { longest_ns_ = 0; }

 private:
  void look(int cpu);

  std::atomic<bool> is_ending_{false};
  std::atomic<std::int64_t> longest_ns_{0};
  std::vector<std::thread> threads_;
};

}  // namespace hapton
