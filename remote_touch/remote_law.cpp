#include "remote_touch/remote_law.h"

#include <utility>

namespace hapton {

RemoteLaw::RemoteLaw(const RemoteMethod& method, std::unique_ptr<RemoteTouch> touch, const Device& device, std::int64_t period_ns)
    : touch_(std::move(touch)), period_ns_(period_ns) {
  if (!method.has_governor) return;
  governor_.emplace(device.limits);
  if (method.is_passive) governor_->keep_passive(device.mechanics);
}

std::optional<double> RemoteLaw::wait(const Vec3& p_WD, double least_s, double most_s) {
  const double period_s = 1e-9 * static_cast<double>(period_ns_);
  for (double waited_s = period_s; waited_s <= most_s; waited_s += period_s) {
    (void)step(p_WD, period_s);
    if (waited_s >= least_s && touch_->is_ready()) return waited_s;
  }
  return std::nullopt;
}

Vec3 RemoteLaw::step(const Vec3& p_WD, double /*dt_s*/) noexcept {
  now_ns_ += period_ns_;
  if (governor_) governor_->observe({.time_ns = now_ns_, .p_WD = p_WD}, DeviceStatus::ready);
  const RemoteStep step = touch_->step(p_WD, now_ns_);
  if (!governor_) return step.force_n;
  std::optional<WrenchCommand> command;
  if (std::exchange(replied_ns_, step.sample_ns) != step.sample_ns) command = WrenchCommand{{.force_n = step.force_n}, step.sample_ns};
  return governor_->step(command, now_ns_).force_n;
}

}  // namespace hapton
