#include "vision_node/gl_target.h"

#include <utility>

namespace hapton {
namespace {

constexpr GLenum kBlendFactors[4] = {GL_BLEND_SRC_RGB, GL_BLEND_DST_RGB, GL_BLEND_SRC_ALPHA, GL_BLEND_DST_ALPHA};
constexpr GLenum kCapabilities[4] = {GL_SCISSOR_TEST, GL_DEPTH_TEST, GL_BLEND, GL_CULL_FACE};

void read_attachment(GLenum attachment, GLint& format, GLint& samples) {
  GLint kind = GL_NONE;
  GLint name = 0;
  glGetFramebufferAttachmentParameteriv(GL_DRAW_FRAMEBUFFER, attachment, GL_FRAMEBUFFER_ATTACHMENT_OBJECT_TYPE, &kind);
  if (kind == GL_NONE) return;
  glGetFramebufferAttachmentParameteriv(GL_DRAW_FRAMEBUFFER, attachment, GL_FRAMEBUFFER_ATTACHMENT_OBJECT_NAME, &name);
  if (kind == GL_RENDERBUFFER) {
    GLint before = 0;
    glGetIntegerv(GL_RENDERBUFFER_BINDING, &before);
    glBindRenderbuffer(GL_RENDERBUFFER, static_cast<GLuint>(name));
    glGetRenderbufferParameteriv(GL_RENDERBUFFER, GL_RENDERBUFFER_INTERNAL_FORMAT, &format);
    glGetRenderbufferParameteriv(GL_RENDERBUFFER, GL_RENDERBUFFER_SAMPLES, &samples);
    glBindRenderbuffer(GL_RENDERBUFFER, static_cast<GLuint>(before));
    return;
  }
  glGetIntegerv(GL_SAMPLES, &samples);
  const GLenum target = samples > 0 ? GL_TEXTURE_2D_MULTISAMPLE : GL_TEXTURE_2D;
  GLint before = 0;
  glGetIntegerv(samples > 0 ? GL_TEXTURE_BINDING_2D_MULTISAMPLE : GL_TEXTURE_BINDING_2D, &before);
  glBindTexture(target, static_cast<GLuint>(name));
  glGetTexLevelParameteriv(target, 0, GL_TEXTURE_INTERNAL_FORMAT, &format);
  glBindTexture(target, static_cast<GLuint>(before));
}

}  // namespace

GlFormat read_bound_format() {
  GlFormat format;
  read_attachment(GL_COLOR_ATTACHMENT0, format.colour, format.samples);
  read_attachment(GL_DEPTH_ATTACHMENT, format.depth, format.samples);
  return format;
}

GlStateGuard::GlStateGuard() {
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &draw_framebuffer_);
  glGetIntegerv(GL_READ_FRAMEBUFFER_BINDING, &read_framebuffer_);
  glGetIntegerv(GL_CURRENT_PROGRAM, &program_);
  glGetIntegerv(GL_VERTEX_ARRAY_BINDING, &vertex_array_);
  glGetIntegerv(GL_ARRAY_BUFFER_BINDING, &array_buffer_);
  glGetIntegerv(GL_DEPTH_FUNC, &depth_function_);
  glGetIntegerv(GL_CULL_FACE_MODE, &cull_face_);
  glGetIntegerv(GL_FRONT_FACE, &front_face_);
  glGetIntegerv(GL_VIEWPORT, viewport_);
  glGetIntegerv(GL_SCISSOR_BOX, scissor_);
  glGetFloatv(GL_COLOR_CLEAR_VALUE, clear_colour_);
  glGetFloatv(GL_LINE_WIDTH, &line_width_);
  glGetBooleanv(GL_DEPTH_WRITEMASK, &depth_mask_);
  glGetBooleanv(GL_COLOR_WRITEMASK, colour_mask_);
  for (int i = 0; i < 4; ++i) glGetIntegerv(kBlendFactors[i], &blend_[i]);
  for (int i = 0; i < 4; ++i) enabled_[i] = glIsEnabled(kCapabilities[i]);
}

GlStateGuard::~GlStateGuard() {
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, static_cast<GLuint>(draw_framebuffer_));
  glBindFramebuffer(GL_READ_FRAMEBUFFER, static_cast<GLuint>(read_framebuffer_));
  glUseProgram(static_cast<GLuint>(program_));
  glBindVertexArray(static_cast<GLuint>(vertex_array_));
  glBindBuffer(GL_ARRAY_BUFFER, static_cast<GLuint>(array_buffer_));
  glDepthFunc(static_cast<GLenum>(depth_function_));
  glCullFace(static_cast<GLenum>(cull_face_));
  glFrontFace(static_cast<GLenum>(front_face_));
  glViewport(viewport_[0], viewport_[1], viewport_[2], viewport_[3]);
  glScissor(scissor_[0], scissor_[1], scissor_[2], scissor_[3]);
  glLineWidth(line_width_);
  glClearColor(clear_colour_[0], clear_colour_[1], clear_colour_[2], clear_colour_[3]);
  glBlendFuncSeparate(static_cast<GLenum>(blend_[0]), static_cast<GLenum>(blend_[1]), static_cast<GLenum>(blend_[2]),
                      static_cast<GLenum>(blend_[3]));
  glDepthMask(depth_mask_);
  glColorMask(colour_mask_[0], colour_mask_[1], colour_mask_[2], colour_mask_[3]);
  for (int i = 0; i < 4; ++i) enabled_[i] != 0 ? glEnable(kCapabilities[i]) : glDisable(kCapabilities[i]);
}

GlTarget::~GlTarget() { release(); }

void GlTarget::release() {
  if (framebuffer_ == 0) return;
  glDeleteFramebuffers(1, &framebuffer_);
  glDeleteRenderbuffers(1, &colour_);
  glDeleteRenderbuffers(1, &depth_);
  framebuffer_ = colour_ = depth_ = 0;
  size_ = {};
}

bool GlTarget::resize(PictureSize size, const GlFormat& format) {
  if (framebuffer_ != 0 && size == size_ && format == format_) return false;
  release();
  size_ = size;
  format_ = format;
  GLint renderbuffer = 0;
  glGetIntegerv(GL_RENDERBUFFER_BINDING, &renderbuffer);
  glGenFramebuffers(1, &framebuffer_);
  glGenRenderbuffers(1, &colour_);
  glGenRenderbuffers(1, &depth_);
  for (const auto& [name, kind] : {std::pair(colour_, format.colour), std::pair(depth_, format.depth)}) {
    glBindRenderbuffer(GL_RENDERBUFFER, name);
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, format.samples, static_cast<GLenum>(kind), size.width_px, size.height_px);
  }
  glBindRenderbuffer(GL_RENDERBUFFER, static_cast<GLuint>(renderbuffer));
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, colour_);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth_);
  return true;
}

void GlTarget::bind() const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  glViewport(0, 0, size_.width_px, size_.height_px);
  glDisable(GL_SCISSOR_TEST);
}

void GlTarget::copy_to_bound(int x, int y) const {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_);
  glDisable(GL_SCISSOR_TEST);
  glBlitFramebuffer(0, 0, size_.width_px, size_.height_px, x, y, x + size_.width_px, y + size_.height_px,
                    GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT, GL_NEAREST);
}

double GlTarget::read_depth(int x, int y) const {
  GLfloat depth = 1.0F;
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_);
  glReadPixels(x, y, 1, 1, GL_DEPTH_COMPONENT, GL_FLOAT, &depth);
  return depth;
}

std::vector<float> GlTarget::read_depths() const {
  std::vector<float> depths(static_cast<std::size_t>(size_.width_px) * static_cast<std::size_t>(size_.height_px));
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_);
  glReadPixels(0, 0, size_.width_px, size_.height_px, GL_DEPTH_COMPONENT, GL_FLOAT, depths.data());
  return depths;
}

void GlTarget::swap(GlTarget& other) noexcept {
  std::swap(size_, other.size_);
  std::swap(format_, other.format_);
  std::swap(framebuffer_, other.framebuffer_);
  std::swap(colour_, other.colour_);
  std::swap(depth_, other.depth_);
}

}  // namespace hapton
