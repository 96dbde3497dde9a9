#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/geometry/screen_rectangle.h"

namespace hapton {

// A file with the pose and size of a screen (TOML, docs/formats.md): `hapton screen` writes it, `vision_node --screen` reads it.

// Error: a screen larger or farther away than a file may have it, as corners in another unit than metres give; one line.
Result<void> check_screen(const ScreenRectangle& screen);

// As text: every number has all its digits.
std::string write_screen(const ScreenRectangle& screen);

// Error: one line with the line in the text: not TOML, unknown or missing keys, numbers outside their ranges, a version that is not ours.
// RT: set-up only.
Result<ScreenRectangle> parse_screen(std::string_view text);
// Error: names the file; also one that cannot be read.
Result<ScreenRectangle> read_screen(const std::filesystem::path& path);

}  // namespace hapton
