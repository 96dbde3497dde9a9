#pragma once

#include <filesystem>
#include <vector>

#include "core/base/result.h"
#include "io_node/io_options.h"

namespace hapton {

// Reads the options of several devices in one process from a TOML file with a [[device]] for each (docs/devices.md has the keys). Options
// missing in the file are as in `common`; the reports of a device go to the folder common.out/NAME. Error: one line with file, line, key
// and how to fix it, also if two devices have the same name, address, hardware or recording file. RT: set-up only.
Result<std::vector<IoOptions>> read_devices_file(const std::filesystem::path& path, const IoOptions& common);

}  // namespace hapton
