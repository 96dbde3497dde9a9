#pragma once

#include <string>
#include <string_view>

#include "core/base/result.h"
#include "vision_node/stereo_camera.h"

namespace hapton {

// Whether the OpenGL renderer with that name draws with the processor.
bool is_software_renderer(std::string_view name);

// How large a picture a renderer can draw.
struct RendererLimits {
  // Most pixels of a picture that the processor draws: those of 7680x4320. A frame of that size takes tenths of a second and 2 GB.
  static constexpr double kMaxSoftwarePixels = 7680.0 * 4320.0;

  std::string renderer;
  PictureSize largest;  // the largest framebuffer

  // Error: one line with what is possible.
  Result<void> check(PictureSize size) const;
};

// The limits of the present renderer. Pre: an OpenGL context is current. RT: no.
RendererLimits read_renderer_limits();

}  // namespace hapton
