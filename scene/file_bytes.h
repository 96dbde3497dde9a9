#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "core/base/result.h"

namespace hapton {

// The contents of a regular file. Error (names the file): missing, unreadable, a directory or device, empty, over max_bytes; it
// grows or shrinks meanwhile. RT: set-up only.
Result<std::string> read_file_bytes(const std::filesystem::path& path, std::size_t max_bytes);

}  // namespace hapton
