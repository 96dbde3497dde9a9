#pragma once

#include <string>

#include "vision_node/stereo_camera.h"

namespace hapton {

// The picture's edges are those of the calibrated screen, however many pixels it has: it is where it should be only if it fills what was
// touched. An aspect that differs by more than this shows that it does not. Touches with a standard deviation of 1 mm leave 0.8 % in the
// aspect of a picture of 240 x 150 mm, a task bar of 40 of 1080 lines 3.7 %.
constexpr double kMaxAspectShare = 0.03;

// A line for the log; empty: nothing to report. size: of the whole picture that the display shows to one eye.
std::string describe_aspect(const ScreenRectangle& screen, PictureSize size);

}  // namespace hapton
