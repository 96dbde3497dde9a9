#pragma once

#include <memory>

#include "core/base/result.h"
#include "io_node/devices/device.h"
#include "io_node/io_options.h"

namespace hapton {

// The device that the options name. RT: set-up only. Error: one line: no trajectory, or one that cannot be read.
Result<std::unique_ptr<Device>> make_device(const IoOptions& options);

}  // namespace hapton
