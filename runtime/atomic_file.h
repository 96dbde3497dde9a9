#pragma once

#include <filesystem>
#include <string_view>

#include "core/base/result.h"

namespace hapton {

// Puts `text` into the file at `path`, making its folder if need be. The file appears whole or not at all, and an older one stays until
// then: the text is written beside it and renamed. RT: no. Error: one line naming the file and the reason.
Result<void> write_file_atomically(const std::filesystem::path& path, std::string_view text);

}  // namespace hapton
