#pragma once

#include <cstdint>

#include "vision_node/gl_target.h"
#include "vision_node/stereo_camera.h"
#include "vision_node/xr/mirror_place.h"

namespace hapton {

// Copies the images of both eyes, which lie beside each other in a framebuffer, the left one left, into textures of a headset's runtime
// and one of them into the window. Bytes are copied as they are, also into textures that are sRGB. Leaves OpenGL's state unchanged.
// Threads: the window's, with its context current, also in the destructor. RT: no.
class EyeCopies {
 public:
  EyeCopies() = default;
  ~EyeCopies();
  EyeCopies(const EyeCopies&) = delete;
  EyeCopies& operator=(const EyeCopies&) = delete;

  // A new frame has been drawn into that framebuffer: images of that size each.
  void take(std::uint32_t framebuffer, PictureSize each);
  // eye 0: the left one. The texture is a GL_TEXTURE_2D of one eye's size.
  void copy_to_texture(std::size_t eye, std::uint32_t texture);
  // The left one, into the window's own back buffer, black around it.
  void copy_to_window(const MirrorPlace& place);
  // Frees what it has made.
  void release();

 private:
  std::uint32_t source_ = 0;
  PictureSize each_;
  GlTarget resolved_;  // of a framebuffer with several samples a pixel
  std::uint32_t into_ = 0;
};

}  // namespace hapton
