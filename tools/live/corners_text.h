#pragma once

#include <string>
#include <string_view>

#include "core/base/result.h"
#include "core/geometry/screen_rectangle.h"

namespace hapton {

// Reads "X,Y,Z;X,Y,Z;X,Y,Z;X,Y,Z", metres, frame W, in the order of kCornerNames. Error: says how to write the corners. RT: no.
Result<ScreenCorners> parse_corners(std::string_view text);

// Text for the terminal: size, position and direction of the picture that best fits the touched corners, and the residuals. RT: no.
std::string describe_fit(const ScreenFit& fit);

}  // namespace hapton
