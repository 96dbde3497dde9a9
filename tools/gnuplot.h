#pragma once

#include <filesystem>
#include <string>

#include "core/base/result.h"

namespace hapton {

// Runs a script of gnuplot's in the folder; it draws into PICTURE.part, which then becomes the picture.
// RT: no. Error: one line: no gnuplot, what it could not draw, a folder that cannot be written to.
Result<std::filesystem::path> draw_with_gnuplot(const std::filesystem::path& folder, const std::string& picture, const std::string& script);

}  // namespace hapton
