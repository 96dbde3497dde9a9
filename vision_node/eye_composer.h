#pragma once

#include <memory>

#include <GL/glew.h>

#include "core/base/result.h"
#include "vision_node/gl_program.h"
#include "vision_node/stereo_camera.h"

namespace hapton {

// Composes the pictures of both eyes for coloured glasses on the graphics processor, with the same result to the bit as VTK, which reads
// both pictures back and uploads the result: that takes as long as drawing them. Threads: the window's. Its context is current, in the
// destructor too. OpenGL's state does not change.
class EyeComposer {
 public:
  // Error: the driver rejects the shaders.
  static Result<std::unique_ptr<EyeComposer>> make();
  ~EyeComposer();
  EyeComposer(const EyeComposer&) = delete;
  EyeComposer& operator=(const EyeComposer&) = delete;

  // Copies the colours of a framebuffer as the picture of the first eye, behind the red glass. Pre: framebuffer is not 0.
  void keep_first_eye(GLuint framebuffer, PictureSize size);
  // Replaces the colours of a framebuffer, the picture of the other eye, by the composition of both. has_colours: as in the mode anaglyph,
  // otherwise as in red_blue. Pre: keep_first_eye() was called before, with the same size; framebuffer is not 0.
  void compose(GLuint framebuffer, PictureSize size, bool has_colours);

 private:
  explicit EyeComposer(GlProgram program);
  struct Copy {
    GLuint framebuffer = 0;
    GLuint texture = 0;
    PictureSize size;
  };
  static void copy_colours(Copy& copy, GLuint framebuffer, PictureSize size);

  GlProgram program_;
  Copy first_eye_;
  Copy second_eye_;
  GLuint table_ = 0;
  GLuint vertices_ = 0;
};

}  // namespace hapton
