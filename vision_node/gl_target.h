#pragma once

#include <vector>

#include <GL/glew.h>

#include "vision_node/stereo_camera.h"

namespace hapton {

// The format of a framebuffer. Between two of one format pixels are copied unchanged, which software does at the speed of memory.
struct GlFormat {
  GLint colour = GL_RGBA8;
  GLint depth = GL_DEPTH_COMPONENT24;
  GLint samples = 0;
  friend bool operator==(const GlFormat&, const GlFormat&) = default;
};

// Of the framebuffer bound for drawing, which must not be the window's own. RT: no.
GlFormat read_bound_format();

// What OpenGL is set to, put back at the end of the scope, so that VTK's own record of it stays true.
class GlStateGuard {
 public:
  GlStateGuard();
  ~GlStateGuard();
  GlStateGuard(const GlStateGuard&) = delete;
  GlStateGuard& operator=(const GlStateGuard&) = delete;

 private:
  GLint draw_ = 0, read_ = 0, program_ = 0, vertices_ = 0, buffer_ = 0, depth_function_ = 0, cull_face_ = 0, front_face_ = 0;
  GLint viewport_[4] = {}, scissor_[4] = {};
  GLfloat clear_[4] = {}, line_width_ = 1.0F;
  GLboolean depth_mask_ = 0, colour_mask_[4] = {};
  GLboolean enabled_[4] = {};
};

// An off-screen picture with depth. Threads: the window's; its context is current, at the end as well.
class GlTarget {
 public:
  GlTarget() = default;
  ~GlTarget();
  GlTarget(const GlTarget&) = delete;
  GlTarget& operator=(const GlTarget&) = delete;

  // Sets size and format; returns true if one changed, and then the content is lost.
  bool shape(PictureSize size, const GlFormat& format);
  PictureSize size() const { return size_; }
  const GlFormat& format() const { return format_; }
  // Everything is drawn into it from now on.
  void bind() const;
  // Colour and depth into the framebuffer that is bound for drawing, from its pixel (x, y). Leaves it bound for drawing.
  void copy_to_bound(int x, int y) const;
  // 0 to 1, of one pixel. Pre: within the size, one sample a pixel.
  double read_depth(int x, int y) const;
  // Of all pixels, by rows from the lower left corner.
  std::vector<float> read_depths() const;
  void swap(GlTarget& other) noexcept;
  void release();

 private:
  PictureSize size_;
  GlFormat format_;
  GLuint framebuffer_ = 0, colour_ = 0, depth_ = 0;
};

}  // namespace hapton
