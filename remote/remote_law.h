#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "loop/force_law.h"
#include "remote/remote_methods.h"
#include "safety/safety_governor.h"

namespace hapton {

// A way to touch across a network as the force law of the laboratory's chain, which has no link of its own then; with io_node's governor
// where the method has it. One period a step. RT: no, whatever ForceLaw says: it is run in simulated time.
class RemoteLaw final : public ForceLaw {
 public:
  struct Device {
    DeviceLimits limits;
    PassivityController::Mechanics mechanics;
  };

  RemoteLaw(const RemoteMethod& method, std::unique_ptr<RemoteTouch> touch, const Device& device, std::int64_t period_ns);

  // The device stays at a place, in free space, until the method has what it needs around it; at least least_s. Seconds that it took; none:
  // not within most_s.
  std::optional<double> wait(const Vec3& p_WD, double least_s, double most_s);

  // The machine stands still for so many periods.
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
  std::int64_t answered_ns_ = 0;
};

}  // namespace hapton
