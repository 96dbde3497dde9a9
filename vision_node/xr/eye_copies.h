#pragma once

#include <cstdint>

#include "vision_node/gl_target.h"
#include "vision_node/stereo_camera.h"
#include "vision_node/xr/mirror_place.h"

namespace hapton {

// Copies the images of both eyes from a framebuffer, in which the left eye's image is the left half, into textures of a headset's runtime,
// and that of the left eye into the window. Bytes are copied without conversion, also into sRGB textures. Leaves OpenGL's state unchanged.
// Threads: the window's, with its context current, also in the destructor. RT: no.
class EyeCopies {
 public:
  EyeCopies() = default;
  ~EyeCopies();
  EyeCopies(const EyeCopies&) = delete;
  EyeCopies& operator=(const EyeCopies&) = delete;

  // Call it when a new frame has been drawn into the framebuffer; that is what is copied next. eye_size: size of one eye's image.
  void take(std::uint32_t framebuffer, PictureSize eye_size);
  // Copies an eye's image (0: left) into a GL_TEXTURE_2D of one eye's size.
  void copy_to_texture(std::size_t eye, std::uint32_t texture);
  // Copies the left eye's image into the window's back buffer; the rest of the window becomes black.
  void copy_to_window(const MirrorPlace& place);
  // Deletes its OpenGL objects.
  void release();

 private:
  std::uint32_t source_framebuffer_ = 0;  // framebuffer with both images, one sample a pixel
  PictureSize eye_size_;
  GlTarget resolved_;                     // the images, if the given framebuffer has several samples a pixel
  std::uint32_t target_framebuffer_ = 0;  // framebuffer for the texture that is written
};

}  // namespace hapton
