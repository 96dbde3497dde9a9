#pragma once

#include <memory>
#include <string>

#include "core/base/result.h"
#include "devices/device.h"
#include "devices/device_settings.h"

namespace hapton {

// A device of 3D Systems / SensAble through their library, libHD, loaded at run time. While the device is in use, the thread of libHD's
// scheduler makes every call that concerns it, once a millisecond, one frame a tick; the servo exchanges data with that thread through a
// DeviceExchange. A thread of ours prints what a person has to do (calibration, warm motors, a device that is gone) and opens the device
// again when it is back. settings.id: the name it was given in the vendor's set-up; empty: "Default Device", "Default PHANToM", or the
// library's own default. library_file: the file to load; empty: libHD by its usual names. W: the device's own axes (x right, y up,
// z towards the user), the origin moved into the middle of its usable workspace. RT: set-up only; the device as Device says. Error: one
// line: library, device or licence missing, and how to fix it.
Result<std::unique_ptr<Device>> make_open_haptics(const DeviceSettings& settings, const std::string& library_file = "");

}  // namespace hapton
