#pragma once

#include <memory>

#include "core/base/result.h"
#include "devices/device.h"
#include "devices/device_settings.h"

namespace hapton {

// A Haply Inverse3, with a VerseGrip where there is one, through the Haply Inverse Service, by default that of this machine: JSON over
// a WebSocket. The service replies to each message with one state, so a thread of ours sends a force 1,000 times a second, even if it is
// zero, and reads the reply. The servo exchanges data with it through a DeviceExchange. If the service or the device disappears, the thread
// connects again when both are back, if it knows the version of the service.
// settings.id: the device's id ("049D"; empty: the first), and after an '@' the service's address ("049D@127.0.0.1:10001").
// W: x right, y up, z towards the user; the origin is the home position of the cursor.
// RT: set-up only; the device as Device says. Error: one line: no service, no device, and how to fix it.
Result<std::unique_ptr<Device>> make_haply(const DeviceSettings& settings);

}  // namespace hapton
