#pragma once

#include <memory>

#include "core/base/result.h"
#include "devices/device.h"
#include "devices/device_settings.h"
#include "hid/space_mouse_reader.h"

namespace hapton {

// A SpaceMouse as a 6-DOF input device. The displacement of the cap sets the velocity of the device point (rate control), by its square for
// fine control near the centre; when the cap is released, the point stays. There are no motors: a force that is written moves the point
// against a viscous resistance (kDampingNsPerM), so that the point comes to rest near a surface that it was pushed into.
// RT and Threads: as Device says.
class SpaceMouseDevice final : public Device {
 public:
  // Choices: half of the workspace in a second; a quarter of a turn in a second.
  static constexpr double kFullSpeedMPerS = 0.15;
  static constexpr double kFullTurnRadPerS = 1.5;
  // At full speed the point goes 7.5 mm into a wall of 1000 N/m.
  static constexpr double kDampingNsPerM = 50.0;

  // Pre: the reader is open.
  explicit SpaceMouseDevice(std::unique_ptr<SpaceMouseReader> reader);

  std::string_view name() const noexcept override { return "SpaceMouse"; }
  const DeviceLimits& limits() const noexcept override { return limits_; }
  DeviceSample read(std::int64_t now_ns) noexcept override;
  void write(const Wrench& wrench, std::int64_t) noexcept override { force_n_ = wrench.force_n; }
  void use_heartbeat_page(HeartbeatPage& page) noexcept override { page.set_means(CutMeans::no_motors); }
  DeviceStatus status() const noexcept override { return reader_->is_there() ? DeviceStatus::ready : DeviceStatus::away; }
  DeviceCondition condition() const noexcept override;
  bool set_hand_target(const std::optional<Vec3>&) noexcept override { return false; }

 private:
  std::unique_ptr<SpaceMouseReader> reader_;
  DeviceLimits limits_;
  DeviceSample sample_;
  Vec3 force_n_ = Vec3::Zero();
  std::int64_t read_ns_ = -1;
};

// settings.id: serial number, path, or index among such devices (from 0). RT: set-up only. Error: one line.
Result<std::unique_ptr<Device>> make_space_mouse(const DeviceSettings& settings);

}  // namespace hapton
