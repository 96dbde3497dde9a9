#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/geometry/screen_rectangle.h"

namespace hapton {

// A file with the pose and size of a screen (TOML, docs/formats.md): `hapton screen` writes it, `vision_node --screen` reads it.

// Error, one line: the screen is larger or farther away than a file permits, as if its corners were not given in metres.
Result<void> check_screen(const ScreenRectangle& screen);

// The text of such a file: every number has all its digits.
std::string write_screen(const ScreenRectangle& screen);

// Error: one line with the line in the text: not TOML, unknown or missing keys, numbers outside their ranges, a version that is not ours.
// RT: set-up only.
Result<ScreenRectangle> parse_screen(std::string_view text);
// Reads such a file. Error: as parse_screen, with the name of the file; it cannot be read.
Result<ScreenRectangle> read_screen(const std::filesystem::path& path);

}  // namespace hapton
