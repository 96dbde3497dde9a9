#pragma once

#include <cstddef>
#include <filesystem>
#include <limits>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace hapton {

// All bytes of a regular file. What is no regular file is refused: a pipe would be waited for as long as nobody writes to it, and a device
// may never end. RT: no. Error: one line with the path, the reason, and the hint: what was looked for there.
Result<std::string> read_regular_file(const std::filesystem::path& path, std::string_view hint,
                                      std::size_t max_bytes = std::numeric_limits<std::size_t>::max());

}  // namespace hapton
