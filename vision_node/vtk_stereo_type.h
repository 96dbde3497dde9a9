#pragma once

#include "vision_node/stereo_camera.h"
#include "vision_node/stereo_mode.h"

namespace hapton {

// VTK's stereo type for a mode; 0 for modes that VTK does not compose: emulate, auto, mono, left, right, fake, side by side, top-bottom and
// OpenXR. RT: yes.
int vtk_stereo_type(StereoMode mode) noexcept;

// The eye that a mode with one viewport draws, for emulate the first one. Modes that compose both eyes do not use it. RT: yes.
Eye find_single_eye(StereoMode mode, bool are_eyes_swapped) noexcept;

}  // namespace hapton
