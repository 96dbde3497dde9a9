#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string_view>

#include "core/base/result.h"

namespace hapton {

// Puts `text` into the file at `path`, making its folder if need be. The file appears whole or not at all, and an older one stays until
// then: the text is written beside it and renamed. RT: no. Error: one line naming the file and the reason.
// For the user alone (mode 0600), or for all that the umask lets.
enum class FileReaders : std::uint8_t { everyone, owner };
Result<void> write_file_atomically(const std::filesystem::path& path, std::string_view text, FileReaders readers = FileReaders::everyone);

// A new, empty file to write, or the one there is emptied; null and errno on failure: ENXIO for a pipe that nobody reads from, which would
// be waited for. Its mode is set even where the file was there before.
std::FILE* open_file_for(const std::filesystem::path& path, FileReaders readers);

}  // namespace hapton
