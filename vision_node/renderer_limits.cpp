#include "vision_node/renderer_limits.h"

#include <algorithm>

#include <GL/glew.h>

namespace hapton {

bool is_software_renderer(std::string_view name) {
  return name.find("llvmpipe") != std::string_view::npos || name.find("softpipe") != std::string_view::npos ||
         name.find("SWR") != std::string_view::npos;
}

Result<void> RendererLimits::check(PictureSize size) const {
  if (size.width_px > largest.width_px || size.height_px > largest.height_px) {
    return fail("--size {}x{}: {} draws pictures of at most {}x{} pixels", size.width_px, size.height_px, renderer, largest.width_px,
                largest.height_px);
  }
  const double pixels = static_cast<double>(size.width_px) * size.height_px;
  if (is_software_renderer(renderer) && pixels > kMaxSoftwarePixels) {
    return fail("--size {}x{}: {} draws with the processor, at most {:.0f} million pixels, such as 7680x4320 or 5760x5760; this is {:.0f}",
                size.width_px, size.height_px, renderer, 1e-6 * kMaxSoftwarePixels, 1e-6 * pixels);
  }
  return {};
}

RendererLimits read_renderer_limits() {
  RendererLimits limits;
  const GLubyte* name = glGetString(GL_RENDERER);
  limits.renderer = name != nullptr ? reinterpret_cast<const char*>(name) : "the renderer";
  GLint viewport[2] = {};
  GLint texture = 0;
  GLint buffer = 0;
  glGetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport);
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &texture);  // VTK's framebuffers are textures
  glGetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &buffer);
  const int both = std::min(texture, buffer);
  limits.largest = {std::min(viewport[0], both), std::min(viewport[1], both)};
  return limits;
}

}  // namespace hapton
