#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string_view>

#include "core/base/result.h"

namespace hapton {

// Who may read a file. `owner`: only the user (mode 0600); `everyone`: whom the umask allows.
enum class FileReaders : std::uint8_t { everyone, owner };
// Writes `text` to the file at `path`, creating its folder if necessary. The text is written to a temporary file, which is renamed: after a
// crash of the process the old file is there, or the complete new one; a power failure may leave it empty (no fsync). A pipe or device is
// written to directly. RT: no. Error: one line naming the file and the reason.
Result<void> write_file_atomically(const std::filesystem::path& path, std::string_view text, FileReaders readers = FileReaders::everyone);

// Creates a file for writing, or truncates an existing one. On failure null, with the reason in errno: ENXIO for a pipe without a reader.
// With `owner` the mode of an existing file becomes 0600, unless it is another user's or its file system has no modes; else it is kept.
std::FILE* open_file_for(const std::filesystem::path& path, FileReaders readers);

}  // namespace hapton
