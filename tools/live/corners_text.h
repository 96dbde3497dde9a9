#pragma once

#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/geometry/screen_rectangle.h"

namespace hapton {

// "X,Y,Z;X,Y,Z;X,Y,Z;X,Y,Z" in metres, frame W, in the order of kCornerNames. Error: one line.
Result<ScreenCorners> parse_corners(std::string_view text);

// What was fitted, for a person: size, place and residuals.
std::string describe_fit(const ScreenFit& fit);

}  // namespace hapton
