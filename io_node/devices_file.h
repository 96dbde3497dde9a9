#pragma once

#include <filesystem>
#include <vector>

#include "core/base/result.h"
#include "io_node/io_options.h"

namespace hapton {

// Several devices in one process: the options of each, from a TOML file with a [[device]] for each (docs/devices.md has the keys). Options
// missing in the file are as in `common`; reports go to a folder of each name below common.out. Error: one line with file, line, key and
// how to fix it. Also: two devices with one name, one address or the same hardware. RT: set-up only.
Result<std::vector<IoOptions>> read_devices_file(const std::filesystem::path& path, const IoOptions& common);

}  // namespace hapton
