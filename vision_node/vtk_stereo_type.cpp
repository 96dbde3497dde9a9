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
    case StereoMode::left:
      return VTK_STEREO_LEFT;
    case StereoMode::right:
      return VTK_STEREO_RIGHT;
    case StereoMode::dresden:
      return VTK_STEREO_DRESDEN;
    case StereoMode::anaglyph:
      return VTK_STEREO_ANAGLYPH;
    case StereoMode::checkerboard:
      return VTK_STEREO_CHECKERBOARD;
    case StereoMode::split_viewport:
      return VTK_STEREO_SPLITVIEWPORT_HORIZONTAL;
    case StereoMode::fake:
      return VTK_STEREO_FAKE;
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

}  // namespace hapton
