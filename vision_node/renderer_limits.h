#pragma once

#include <string>
#include <string_view>

#include "core/base/result.h"
#include "vision_node/stereo_camera.h"

namespace hapton {

// Whether OpenGL's renderer of that name draws with the processor.
bool is_software_renderer(std::string_view name);

// How large a picture a renderer draws.
struct RendererLimits {
  // Of a renderer that draws with the processor: 7680x4320. A frame of that size takes tenths of a second and 2 GB.
  static constexpr double kMaxSoftwarePixels = 7680.0 * 4320.0;

  std::string renderer;
  PictureSize largest;  // of its framebuffers

  // Error: one line with what is possible.
  Result<void> check(PictureSize size) const;
};

// Pre: an OpenGL context is current. RT: no.
RendererLimits read_renderer_limits();

}  // namespace hapton
