#pragma once

#include <string>

#include "vision_node/stereo_camera.h"

namespace hapton {

// The picture is drawn for the edges of the calibrated screen, however many pixels it has: it is in the right place only if it fills the
// area whose corners were touched. If the aspects differ by more than this share, it does not. Touches with a standard deviation of 1 mm
// change the aspect of a picture of 240 x 150 mm by 0.8 %, a task bar of 40 of 1080 lines changes it by 3.7 %.
constexpr double kMaxAspectShare = 0.03;

// A line for the log; empty: nothing to report. size: size of the whole picture that the display shows to one eye.
std::string describe_aspect(const ScreenRectangle& screen, PictureSize size);

}  // namespace hapton
