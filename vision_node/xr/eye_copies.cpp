#include "vision_node/xr/eye_copies.h"

#include <GL/glew.h>

namespace hapton {
namespace {

// Disables GL_FRAMEBUFFER_SRGB during its lifetime, so that bytes are copied into an sRGB texture without conversion.
class NoSrgb {
 public:
  NoSrgb() : was_on_(glIsEnabled(GL_FRAMEBUFFER_SRGB)) { glDisable(GL_FRAMEBUFFER_SRGB); }
  ~NoSrgb() {
    if (was_on_ != GL_FALSE) glEnable(GL_FRAMEBUFFER_SRGB);
  }
  NoSrgb(const NoSrgb&) = delete;
  NoSrgb& operator=(const NoSrgb&) = delete;

 private:
  GLboolean was_on_;
};

}  // namespace

EyeCopies::~EyeCopies() { release(); }

void EyeCopies::release() {
  resolved_.release();
  if (target_framebuffer_ != 0) glDeleteFramebuffers(1, &target_framebuffer_);
  target_framebuffer_ = 0;
}

void EyeCopies::take(std::uint32_t framebuffer, PictureSize eye_size) {
  const GlStateGuard guard;
  eye_size_ = eye_size;
  source_framebuffer_ = framebuffer;
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  GlFormat format = read_bound_format();
  if (format.samples == 0) return;
  format.samples = 0;
  const PictureSize both = {2 * eye_size.width_px, eye_size.height_px};
  resolved_.resize(both, format);
  resolved_.bind();
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer);
  glBlitFramebuffer(0, 0, both.width_px, both.height_px, 0, 0, both.width_px, both.height_px, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  GLint name = 0;
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &name);
  source_framebuffer_ = static_cast<std::uint32_t>(name);
}

void EyeCopies::copy_to_texture(std::size_t eye, std::uint32_t texture) {
  const GlStateGuard guard;
  const NoSrgb no_srgb;
  if (target_framebuffer_ == 0) glGenFramebuffers(1, &target_framebuffer_);
  glDisable(GL_SCISSOR_TEST);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, source_framebuffer_);
  glReadBuffer(GL_COLOR_ATTACHMENT0);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, target_framebuffer_);
  glFramebufferTexture2D(GL_DRAW_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
  const int from = static_cast<int>(eye) * eye_size_.width_px;
  glBlitFramebuffer(from, 0, from + eye_size_.width_px, eye_size_.height_px, 0, 0, eye_size_.width_px, eye_size_.height_px,
                    GL_COLOR_BUFFER_BIT, GL_NEAREST);
  glFramebufferTexture2D(GL_DRAW_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, 0, 0);
}

void EyeCopies::copy_to_window(const MirrorPlace& place) {
  const GlStateGuard guard;
  const NoSrgb no_srgb;
  glDisable(GL_SCISSOR_TEST);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, source_framebuffer_);
  glReadBuffer(GL_COLOR_ATTACHMENT0);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
  glDrawBuffer(GL_BACK);
  glClearColor(0.0F, 0.0F, 0.0F, 1.0F);
  glClear(GL_COLOR_BUFFER_BIT);
  glBlitFramebuffer(0, 0, eye_size_.width_px, eye_size_.height_px, place.x_px, place.y_px, place.x_px + place.size.width_px,
                    place.y_px + place.size.height_px, GL_COLOR_BUFFER_BIT, GL_LINEAR);
}

}  // namespace hapton
