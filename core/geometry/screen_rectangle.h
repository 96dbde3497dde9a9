#pragma once

#include <array>
#include <string_view>

#include "core/base/result.h"
#include "core/math/types.h"

namespace hapton {

// The picture on a real screen. Frame R: origin in the centre of the picture, x right, y up, z towards the viewer. Units: metres, in real
// size.
struct ScreenRectangle {
  Pose X_WR = Pose::Identity();
  double width_m = 0.0;
  double height_m = 0.0;
};

// Always in this order: lower left, lower right, upper right, upper left, as the viewer sees them. Frame W.
using ScreenCorners = std::array<Vec3, 4>;
inline constexpr std::array<std::string_view, 4> kCornerNames = {"lower left", "lower right", "upper right", "upper left"};
ScreenCorners find_corners(const ScreenRectangle& screen);

// Farther from the fitted rectangle, as a share of its diagonal, at least one corner was touched beside it. If one corner is off by e and
// three are exact, a residual is at least e / 4, and the fitted picture is off by at most 3/4 e: with 1 % no picture that one wrong corner
// moves by more than 3 % of the diagonal is accepted. Touches with a standard deviation of 1 mm along each axis are accepted 997 times in
// 1,000 for a diagonal of 250 mm.
constexpr double kMaxResidualShare = 0.01;
// A side below this, or below that share of the other one, is not a picture.
constexpr double kMinSideM = 0.02;
constexpr double kMinSideShare = 0.05;

// The rectangle that is closest to the touched corners, and how far each of them is from its corner.
struct ScreenFit {
  ScreenRectangle screen;
  std::array<double, 4> residuals_m = {};
};

// Least squares over position, orientation and both sides, in closed form. Error, one line that says what to do: corners that are not
// finite, that span no rectangle, that were touched in another order, or that are too far from the rectangle. The order is known because
// W's x is the user's right, y up and z towards the user: the picture's x must point more to the right than its y does, and the picture
// face up or towards the user. RT: set-up only.
Result<ScreenFit> fit_screen(const ScreenCorners& corners_W);

}  // namespace hapton
