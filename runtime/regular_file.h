#pragma once

#include <cstddef>
#include <filesystem>
#include <limits>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace hapton {

// All bytes of a regular file. Other files are rejected: reading a pipe would wait for a writer, and a device may never end. RT: no. Error:
// one line with the path, the reason, and the hint, which says what file was expected there.
Result<std::string> read_regular_file(const std::filesystem::path& path, std::string_view hint,
                                      std::size_t max_bytes = std::numeric_limits<std::size_t>::max());

}  // namespace hapton
