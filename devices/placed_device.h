#pragma once

#include <memory>

#include "devices/device.h"

namespace hapton {

// A device that stands elsewhere in W than its driver assumes: beside another device, or turned. What it takes and returns is in W, except
// turn_hand. Its workspace is the box around the turned workspace of the driver's device. RT: as that device.
class PlacedDevice final : public Device {
 public:
  // X_WB: pose in W of the base frame that the device itself takes for W.
  PlacedDevice(std::unique_ptr<Device> device, const Pose& X_WB);

  std::string_view name() const noexcept override { return device_->name(); }
  const DeviceLimits& limits() const noexcept override { return limits_; }
  DeviceSample read(std::int64_t now_ns) noexcept override;
  void write(const Wrench& wrench, std::int64_t now_ns) noexcept override;
  bool cut() noexcept override { return device_->cut(); }
  void restore() noexcept override { device_->restore(); }
  void use_heartbeat_page(HeartbeatPage& page) noexcept override { device_->use_heartbeat_page(page); }
  DeviceStatus status() const noexcept override { return device_->status(); }
  DeviceCondition condition() const noexcept override { return device_->condition(); }
  bool set_hand_target(const std::optional<Vec3>& p_WH) noexcept override;
  bool press_hand_buttons(std::uint32_t buttons) noexcept override { return device_->press_hand_buttons(buttons); }
  bool turn_hand(const Vec3& turn_rad) noexcept override { return device_->turn_hand(turn_rad); }
  bool aim_hand(std::span<const Vec3> p_WA) noexcept override;

 private:
  std::unique_ptr<Device> device_;
  Pose X_WB_;
  Pose X_BW_;
  Quat q_WB_;
  DeviceLimits limits_;
};

}  // namespace hapton
