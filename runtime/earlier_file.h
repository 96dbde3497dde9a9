#pragma once

#include <filesystem>

#include "core/base/result.h"

namespace hapton {

// Renames a regular file that is not empty, so that a new one can be written at `path` without replacing it: day.hapton becomes
// day-1.hapton, or day-2.hapton if that exists, and so on. If `path` is a link, the file that it points to is renamed. Another process may
// continue to write to the renamed file. Returns the new name; empty: there was nothing to keep. RT: no. Threads: any. Error: one line with
// the path, the reason and what to do.
Result<std::filesystem::path> keep_earlier_file(const std::filesystem::path& path);

}  // namespace hapton
