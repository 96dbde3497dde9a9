#pragma once

#include <memory>
#include <string>

#include "core/base/result.h"
#include "devices/device.h"
#include "devices/device_settings.h"
#include "plugin/plugin_file.h"

namespace hapton {

// A device from a shared library (plugin/hapton_plugin.h). The governor checks its samples like those of any device. If the plug-in throws
// a C++ exception, the device has the status fault from then on. RT: as Device, if the plug-in keeps to that.
class PluginDevice final : public Device {
 public:
  // Error: one line: the file cannot be used, the plug-in rejects its parameters, or its limits are impossible.
  static Result<std::unique_ptr<PluginDevice>> make(const PluginChoice& choice);
  // Writes zero force to the device and closes it.
  ~PluginDevice() override;
  PluginDevice(const PluginDevice&) = delete;
  PluginDevice& operator=(const PluginDevice&) = delete;

  std::string_view name() const noexcept override { return name_; }
  const DeviceLimits& limits() const noexcept override { return limits_; }
  DeviceSample read(std::int64_t now_ns) noexcept override;
  void write(const Wrench& wrench, std::int64_t now_ns) noexcept override;
  DeviceStatus status() const noexcept override { return status_; }
  // The device's own code is in this process, so only the end of the process releases the force.
  void use_heartbeat_page(HeartbeatPage& page) noexcept override { page.set_means(CutMeans::kill); }
  bool set_hand_target(const std::optional<Vec3>&) noexcept override { return false; }

 private:
  PluginDevice(PluginFile file, const hapton_device_api& api);
  Result<void> take_limits(const hapton_device_limits& limits);

  PluginFile file_;
  const hapton_device_api& api_;
  std::string name_;
  void* device_ = nullptr;
  DeviceLimits limits_;
  DeviceStatus status_ = DeviceStatus::ready;
  DeviceSample last_;  // the last sample with status ready
};

// How the value of --device begins for a plug-in: "plugin:FILE.so:KEY=VALUE,...".
constexpr std::string_view kPluginDevice = "plugin:";

// RT: set-up only. Error: as PluginDevice::make.
Result<std::unique_ptr<Device>> make_plugin_device(const DeviceSettings& settings);

}  // namespace hapton
