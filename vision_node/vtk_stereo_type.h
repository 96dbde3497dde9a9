#pragma once

#include "vision_node/stereo_mode.h"

namespace hapton {

// VTK's own stereo type of a mode; 0 for one that VTK does not make: emulate, auto, mono, side by side, top-bottom and OpenXR. RT: yes.
int vtk_stereo_type(StereoMode mode) noexcept;

}  // namespace hapton
