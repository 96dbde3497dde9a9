#pragma once

#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/geometry/screen_rectangle.h"

namespace hapton {

// Reads "X,Y,Z;X,Y,Z;X,Y,Z;X,Y,Z", metres, frame W, in the order of kCornerNames. Error: one line. RT: no.
Result<ScreenCorners> parse_corners(std::string_view text);

// Describes a fit for the terminal: size, place and residuals. RT: no.
std::string describe_fit(const ScreenFit& fit);

}  // namespace hapton
