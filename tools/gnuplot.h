#pragma once

#include <filesystem>
#include <string>

#include "core/base/result.h"

namespace hapton {

// Runs a gnuplot script in `folder`, which is made if it is not there. The script draws into PICTURE.part, which is renamed to the picture
// when gnuplot succeeds. Returns the picture's path. Error: one line: gnuplot is missing, cannot draw, or the folder is not writable. RT:
// no.
Result<std::filesystem::path> draw_with_gnuplot(const std::filesystem::path& folder, const std::string& picture, const std::string& script);

}  // namespace hapton
