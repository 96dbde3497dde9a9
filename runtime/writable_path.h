#pragma once

#include <filesystem>

#include "core/base/result.h"

namespace hapton {

// Whether a folder can be written to, or made; whether a file can be written there, or replaced (PartPath), by a name that fits. A folder
// that a link leads to must be there: nobody makes one through a link. Leaves nothing behind: for the start of what writes at its end.
// Error: one line with the path, the reason and what to do. RT: no.
Result<void> check_writable_folder(const std::filesystem::path& folder);
Result<void> check_writable_file(const std::filesystem::path& file);

}  // namespace hapton
