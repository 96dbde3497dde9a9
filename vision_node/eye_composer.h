#pragma once

#include <memory>

#include <GL/glew.h>

#include "core/base/result.h"
#include "vision_node/gl_program.h"
#include "vision_node/stereo_camera.h"

namespace hapton {

// Composes the pictures of both eyes for coloured glasses on the graphics side, to the bit as VTK does it with the processor: which reads
// both pictures back and uploads the result, and takes as long as drawing them. Threads: the window's; its context is current, at the end
// as well. OpenGL's state stays as it is.
class EyeComposer {
 public:
  // Error: shaders that the driver rejects.
  static Result<std::unique_ptr<EyeComposer>> make();
  ~EyeComposer();
  EyeComposer(const EyeComposer&) = delete;
  EyeComposer& operator=(const EyeComposer&) = delete;

  // Takes the colours of a framebuffer as the picture of the eye behind the red glass.
  void keep(GLuint framebuffer, PictureSize size);
  // Replaces the colours of a framebuffer, the picture of the other eye, by what both make. has_colours: as in mode anaglyph, otherwise as
  // in red_blue. Pre: keep(), and of the same size since.
  void compose(GLuint framebuffer, PictureSize size, bool has_colours);

 private:
  explicit EyeComposer(GlProgram program);
  struct Copy {
    GLuint framebuffer = 0;
    GLuint texture = 0;
    PictureSize size;
  };
  static void take(Copy& copy, GLuint framebuffer, PictureSize size);

  GlProgram program_;
  Copy first_;
  Copy second_;
  GLuint table_ = 0;
  GLuint vertices_ = 0;
};

}  // namespace hapton
