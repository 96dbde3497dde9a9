#pragma once

#include <vector>

#include <GL/glew.h>

#include "vision_node/stereo_camera.h"

namespace hapton {

// The format of a framebuffer. Between two framebuffers of the same format, pixels are copied without conversion, which is fast in
// software.
struct GlFormat {
  GLint colour = GL_RGBA8;
  GLint depth = GL_DEPTH_COMPONENT24;
  GLint samples = 0;
  friend bool operator==(const GlFormat&, const GlFormat&) = default;
};

// The format of the framebuffer bound for drawing. Pre: that framebuffer is not the window's own. RT: no.
GlFormat read_bound_format();

// Saves the OpenGL state that its members hold and restores it at the end of the scope, so that VTK's cached copy of it stays valid.
class GlStateGuard {
 public:
  GlStateGuard();
  ~GlStateGuard();
  GlStateGuard(const GlStateGuard&) = delete;
  GlStateGuard& operator=(const GlStateGuard&) = delete;

 private:
  GLint draw_framebuffer_ = 0, read_framebuffer_ = 0, program_ = 0, vertex_array_ = 0, array_buffer_ = 0, depth_function_ = 0,
        cull_face_ = 0, front_face_ = 0;
  GLint viewport_[4] = {}, scissor_[4] = {};
  GLfloat clear_colour_[4] = {}, line_width_ = 1.0F;
  GLint blend_[4] = {};  // factors for source and destination of colours, then of alphas
  GLboolean depth_mask_ = 0, colour_mask_[4] = {};
  GLboolean enabled_[4] = {};
};

// An off-screen framebuffer with colour and depth. Threads: the window's, with its context current, also in the destructor.
class GlTarget {
 public:
  GlTarget() = default;
  ~GlTarget();
  GlTarget(const GlTarget&) = delete;
  GlTarget& operator=(const GlTarget&) = delete;

  // Sets size and format. True: one of them changed; then the content is lost, and this framebuffer is bound.
  bool resize(PictureSize size, const GlFormat& format);
  PictureSize size() const { return size_; }
  const GlFormat& format() const { return format_; }
  // Draw calls that follow go to this framebuffer, to all of it.
  void bind() const;
  // Copies colour and depth to the framebuffer bound for drawing, with (x, y) as the lower left pixel. That framebuffer stays bound.
  void copy_to_bound(int x, int y) const;
  // Depth of one pixel, 0 to 1. Pre: inside the framebuffer, one sample a pixel.
  double read_depth(int x, int y) const;
  // Depths of all pixels, by rows from the lower left corner. Pre: one sample a pixel.
  std::vector<float> read_depths() const;
  void swap(GlTarget& other) noexcept;
  void release();

 private:
  PictureSize size_;
  GlFormat format_;
  GLuint framebuffer_ = 0, colour_ = 0, depth_ = 0;
};

}  // namespace hapton
