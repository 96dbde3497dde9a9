#pragma once

#include <array>
#include <string_view>

#include "core/base/result.h"
#include "core/math/types.h"

namespace hapton {

// The rectangle of the picture on a real screen. Frame R: origin in the centre of the picture, x right, y up, z towards the viewer. Units:
// metres, in real size.
struct ScreenRectangle {
  Pose X_WR = Pose::Identity();
  double width_m = 0.0;
  double height_m = 0.0;
};

// Always in this order: lower left, lower right, upper right, upper left, as the viewer sees them. Frame W.
using ScreenCorners = std::array<Vec3, 4>;
inline constexpr std::array<std::string_view, 4> kCornerNames = {"lower left", "lower right", "upper right", "upper left"};
ScreenCorners find_corners(const ScreenRectangle& screen);

// The largest accepted distance of a touched point from its corner of the fitted rectangle, as a share of the diagonal: beyond it at least
// one point is not at a corner. If one point is off by e and three are exact, a residual is at least e / 4, and the fitted picture is off
// by at most 3/4 e: with 1 % no picture that one wrong point moves by more than 3 % of the diagonal is accepted. Points with a standard
// deviation of 1 mm along each axis are accepted 997 times in 1,000 for a diagonal of 250 mm.
constexpr double kMaxResidualShare = 0.01;
// A rectangle with a side below kMinSideM, or below kMinSideShare of the other side, is rejected as a picture.
constexpr double kMinSideM = 0.02;
constexpr double kMinSideShare = 0.05;

// The rectangle that is closest to the touched points, and how far each of them is from its corner.
struct ScreenFit {
  ScreenRectangle screen;
  std::array<double, 4> residuals_m = {};
};

// Least squares over position, orientation and both sides, in closed form. Error, in one line that says what to do: points that are not
// finite, span no rectangle, were touched in another order or are too far from the rectangle. The order can be checked because W has x to
// the user's right, y up and z towards the user: the x axis of the picture must point more to the right than its y axis does, and the
// picture must face up or towards the user. Frame W. RT: set-up only.
Result<ScreenFit> fit_screen(const ScreenCorners& corners_W);

}  // namespace hapton
