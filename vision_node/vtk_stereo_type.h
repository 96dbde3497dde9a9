#pragma once

#include "vision_node/stereo_camera.h"
#include "vision_node/stereo_mode.h"

namespace hapton {

// VTK's own stereo type of a mode; 0 for one that VTK does not make: emulate, auto, mono, left, right, fake, side by side, top-bottom and
// OpenXR. RT: yes.
int vtk_stereo_type(StereoMode mode) noexcept;

// The eye of a mode of one view. Where both eyes are composed it does not matter. RT: yes.
Eye find_single_eye(StereoMode mode, bool swapped) noexcept;

}  // namespace hapton
