#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "closed_loop/force_law.h"
#include "remote_touch/remote_methods.h"
#include "safety/safety_governor.h"

namespace hapton {

// A method of touch across a network, as the force law of the laboratory's chain. It simulates the network itself, so the chain must have
// no link; it contains io_node's governor if the method has one. One step is one period. RT: no, unlike other force laws: for simulated
// time only.
class RemoteLaw final : public ForceLaw {
 public:
  struct Device {
    DeviceLimits limits;
    PassivityController::Mechanics mechanics;
  };

  RemoteLaw(const RemoteMethod& method, std::unique_ptr<RemoteTouch> touch, const Device& device, std::int64_t period_ns);

  // Keeps the device at a position in free space until the method has received what it needs around this position, for at least least_s.
  // Returns the seconds that this took; none: more than most_s.
  std::optional<double> wait(const Vec3& p_WD, double least_s, double most_s);

  // Lets this number of periods pass without a step, as when the machine stalls.
  void skip(std::size_t periods) noexcept { now_ns_ += static_cast<std::int64_t>(periods) * period_ns_; }
  Vec3 step(const Vec3& p_WD, double dt_s) noexcept override;
  void reset(const Vec3& p_WD) noexcept override { (void)p_WD; }

  const RemoteTouch& touch() const noexcept { return *touch_; }
  std::int64_t now_ns() const noexcept { return now_ns_; }

 private:
  std::unique_ptr<RemoteTouch> touch_;
  std::optional<SafetyGovernor> governor_;
  std::int64_t period_ns_;
  std::int64_t now_ns_ = 1'000'000'000;
  std::int64_t replied_ns_ = 0;
};

}  // namespace hapton
