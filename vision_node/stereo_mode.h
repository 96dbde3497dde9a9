#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace hapton {

// How the two eyes' pictures share the window. Drawn by our own code: side_by_side (two viewports, each with its own aspect), top_bottom
// (two viewports of half the height, the left eye's above, as 3D displays stretch them), emulate (the eyes in turn, one in each picture;
// VTK 9.1 draws both and leaves the right one), left, right, fake (the left one), red_blue and anaglyph. mono has one eye. All others are
// VTK's compositing with our matrices for each eye; in split_viewport each picture has half the width, as 3D televisions stretch it.
// openxr: the images are those of a headset, and the window shows one of them.
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

// The mode's name on the command line.
std::string_view stereo_mode_name(StereoMode mode);

// All names that --stereo accepts.
std::vector<std::string> stereo_mode_names();

// The mode with that name. Error: the name is unknown; the message lists the known ones.
Result<StereoMode> find_stereo_mode(std::string_view name);

}  // namespace hapton
