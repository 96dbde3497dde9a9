#pragma once

#include <filesystem>

#include "core/base/result.h"

namespace hapton {

// Checks that a folder can be written to or made, or that a file can be written or replaced (PartPath); also that the names are not too
// long. A folder that a link points to must exist, because none can be made through a link. Leaves nothing behind. For programs that write
// their results at the end and should fail at the start. Error: one line with the path, the reason and what to do. RT: no.
Result<void> check_writable_folder(const std::filesystem::path& folder);
Result<void> check_writable_file(const std::filesystem::path& file);

}  // namespace hapton
