#pragma once

#include <atomic>
#include <mutex>
#include <thread>

#include "link/link_key.h"
#include "link/messages.h"

namespace hapton::guest {

// A haptics node with one wall: below a height z in W it exerts a spring force along z.
class WallHaptics {
 public:
  static constexpr double kStiffnessNPerM = 300.0;

  WallHaptics(const std::string& hub, const LinkKey& key, double wall_z_m);
  ~WallHaptics();
  WallHaptics(const WallHaptics&) = delete;
  WallHaptics& operator=(const WallHaptics&) = delete;

  std::uint64_t states() const { return states_; }
  DeviceState newest() const {
    const std::lock_guard lock(mutex_);
    return newest_;
  }

 private:
  void run(const std::string& hub, const LinkKey& key);

  double wall_z_m_;
  std::atomic<bool> ends_ = false;
  std::atomic<std::uint64_t> states_ = 0;
  mutable std::mutex mutex_;
  DeviceState newest_;
  std::thread thread_;
};

}  // namespace hapton::guest
