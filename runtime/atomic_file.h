#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string_view>

#include "core/base/result.h"

namespace hapton {

// Writes `text` to the file at `path`, creating its folder if necessary. The file appears complete or not at all, and an older one stays
// until then: the text is written to a temporary file, which is renamed. RT: no. Error: one line naming the file and the reason. For the
// user alone (mode 0600), or as the umask allows.
enum class FileReaders : std::uint8_t { everyone, owner };
Result<void> write_file_atomically(const std::filesystem::path& path, std::string_view text, FileReaders readers = FileReaders::everyone);

// Creates a file for writing, or truncates an existing one; null and errno on failure: ENXIO for a pipe without a reader. The mode of an
// existing file is set too.
std::FILE* open_file_for(const std::filesystem::path& path, FileReaders readers);

}  // namespace hapton
