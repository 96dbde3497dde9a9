#pragma once

#include <array>
#include <string_view>

#include "core/base/result.h"

namespace hapton {

// Reads the numbers of cells along x, y and z from "32" (the same along all three) or "64x32x16". RT: set-up only. Error: one line with
// the text and what is expected.
Result<std::array<int, 3>> parse_grid_division(std::string_view text);

}  // namespace hapton
