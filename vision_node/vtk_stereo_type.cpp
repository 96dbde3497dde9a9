#include "vision_node/vtk_stereo_type.h"

#include <vtkRenderWindow.h>

namespace hapton {

int vtk_stereo_type(StereoMode mode) noexcept {
  switch (mode) {
    case StereoMode::crystal_eyes:
      return VTK_STEREO_CRYSTAL_EYES;
    case StereoMode::red_blue:
      return VTK_STEREO_RED_BLUE;
    case StereoMode::interlaced:
      return VTK_STEREO_INTERLACED;
    case StereoMode::dresden:
      return VTK_STEREO_DRESDEN;
    case StereoMode::anaglyph:
      return VTK_STEREO_ANAGLYPH;
    case StereoMode::checkerboard:
      return VTK_STEREO_CHECKERBOARD;
    case StereoMode::split_viewport:
      return VTK_STEREO_SPLITVIEWPORT_HORIZONTAL;
    case StereoMode::left:
    case StereoMode::right:
    case StereoMode::fake:
    case StereoMode::emulate:
    case StereoMode::automatic:
    case StereoMode::mono:
    case StereoMode::side_by_side:
    case StereoMode::top_bottom:
    case StereoMode::openxr:
      return 0;
  }
  return 0;
}

Eye find_single_eye(StereoMode mode, bool are_eyes_swapped) noexcept {
  if (mode == StereoMode::emulate) return Eye::left;
  const bool is_left = mode == StereoMode::left || mode == StereoMode::fake;
  if (!is_left && mode != StereoMode::right) return Eye::centre;
  return is_left != are_eyes_swapped ? Eye::left : Eye::right;
}

}  // namespace hapton
