#pragma once

#include <filesystem>
#include <string>

#include "core/base/result.h"

namespace hapton {

// Runs a gnuplot script in `folder`, which is created if it does not exist. The script writes `picture`.part, which is renamed to `picture`
// if gnuplot succeeds. Returns the path of the picture. Error, one line: gnuplot is missing, fails or takes longer than `timeout_s`, or the
// folder is not writable. RT: no.
Result<std::filesystem::path> draw_with_gnuplot(const std::filesystem::path& folder, const std::string& picture, const std::string& script,
                                                double timeout_s = 60.0);

}  // namespace hapton
