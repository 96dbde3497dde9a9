#pragma once

#include <atomic>
#include <cstdint>
#include <latch>
#include <thread>
#include <vector>

namespace hapton {

// Measures how long this machine stood still: on each CPU a thread of the highest real-time priority (an ordinary one where the user may
// not have that) reads the clock every millisecond. While that thread could not run, no program on that CPU could, whatever its
// priority: a hypervisor ran something else. Units: ns. Threads: any.
class StallWatch {
 public:
  // The largest age of a force (docs/safety-case.md): a node that stalls for longer must release the force, and a test notices that.
  static constexpr std::int64_t kForceLifeNs = 20'000'000;

  // Returns when every thread has begun to read the clock.
  StallWatch();
  ~StallWatch() { end(); }
  StallWatch(const StallWatch&) = delete;
  StallWatch& operator=(const StallWatch&) = delete;

  // The longest delay of a reading of the clock since construction or restart(). A stall counts only after the next reading.
  std::int64_t longest_ns() const { return longest_ns_.load(); }
  void restart() { longest_ns_ = 0; }
  // Lets every thread read the clock once more, and ends it. Returns longest_ns(), which then includes a stall that ends now.
  std::int64_t end();

 private:
  void watch_cpu(int cpu, std::latch& are_started);

  std::atomic<bool> is_ending_{false};
  std::atomic<std::int64_t> longest_ns_{0};
  std::vector<std::thread> threads_;
};

}  // namespace hapton
