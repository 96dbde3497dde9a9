#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace hapton {

// How the two eyes' pictures share the window. Ours are side_by_side (two viewports, each with its own aspect), top_bottom (two viewports
// of half the height, the left eye's above, as 3D displays stretch them) and emulate (the eyes in turn, one a picture; VTK 9.1's own draws
// both and leaves the right one), left, right and fake (the left one), and the coloured ones, red_blue and anaglyph. All others but mono
// are VTK's compositing, fed with our per-eye matrices: split_viewport is its half-width side by side, as 3D televisions stretch it.
// openxr: the images are a headset's, and the window shows one of them.
enum class StereoMode {
  automatic,
  mono,
  side_by_side,
  top_bottom,
  crystal_eyes,
  red_blue,
  interlaced,
  left,
  right,
  dresden,
  anaglyph,
  checkerboard,
  split_viewport,
  fake,
  emulate,
  openxr
};

// Its name on the command line.
std::string_view stereo_mode_name(StereoMode mode);

// All names that --stereo accepts.
std::vector<std::string> stereo_mode_names();

// Error: an unknown name; the line lists the known ones.
Result<StereoMode> find_stereo_mode(std::string_view name);

}  // namespace hapton
