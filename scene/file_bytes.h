#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "core/base/result.h"

namespace hapton {

// The contents of a regular file. Error (names the file): it is missing, unreadable, a directory or device, empty or larger than max_bytes;
// or its size changes while it is read. RT: set-up only.
Result<std::string> read_file_bytes(const std::filesystem::path& path, std::size_t max_bytes);

}  // namespace hapton
