#pragma once

#include <memory>
#include <string>

#include "core/base/result.h"
#include "devices/device.h"
#include "devices/device_settings.h"

namespace hapton {

struct ForceDimensionOptions {
  std::string library_file;              // empty: libdrd or libdhd by their usual names
  double warning_before_moving_s = 3.0;  // time between the warning and the motion of a device that calibrates itself
};

// A device of Force Dimension, or a Novint Falcon, through the Force Dimension SDK, loaded at run time. While the device is in use, a
// thread of ours makes every call, 1,000 times a second; the servo exchanges data with it through a DeviceExchange. The firmware's own
// watchdog is set too, and its velocity threshold stays as it is. settings.id: number of the device, from 0; empty: 0. Frame W: x right, y
// up, z towards the user (y, z, x of the device); the origin is that of the device. RT: set-up only; the device: see Device. Error: one
// line: library or device missing, and how to fix it.
Result<std::unique_ptr<Device>> make_force_dimension(const DeviceSettings& settings, const ForceDimensionOptions& options = {});

}  // namespace hapton
