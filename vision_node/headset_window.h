#pragma once

#include <cstddef>

#include "vision_node/stereo_camera.h"
#include "vision_node/xr/eye_copies.h"
#include "vision_node/xr/headset.h"
#include "vision_node/xr/mirror_place.h"

class vtkOpenGLRenderWindow;

namespace hapton {

// VTK's window while it draws for a headset: then both eyes' images lie beside each other in VTK's framebuffer, in a size of their own,
// and the window on the screen, of any size, shows the left one. Threads: the window's. RT: no.
class HeadsetWindow {
 public:
  // Pre: window outlives this and is initialised. is_mapped: there is a window on the screen; otherwise size is that of its image.
  HeadsetWindow(vtkOpenGLRenderWindow* window, bool is_mapped, PictureSize size) : window_(window), is_mapped_(is_mapped), size_(size) {}

  // From now on VTK draws two images of that size. Call it before each frame: when a window is resized VTK takes its size.
  void enter(PictureSize each);
  // From now on it draws for the window. Nothing happens if it does already.
  void leave();

  // A frame has been drawn: its images are the ones that are copied.
  void take_frame();
  void copy_eye(std::size_t eye, unsigned texture) { copies_.copy_to_texture(eye, texture); }
  // Nothing where no window is mapped.
  void show_mirror();
  // What the pointer at that pixel of the window points at, in the left eye's image.
  Eigen::Vector2i find_pixel(int window_x_px, int window_y_px) const;

  GlxWindow handles();
  // Pre: the context is current. Frees what is OpenGL's.
  void release() { copies_.release(); }

 private:
  PictureSize mapped_size() const;

  vtkOpenGLRenderWindow* window_;
  bool is_mapped_;
  PictureSize size_;
  PictureSize each_;  // of an eye; none while it draws for the window
  EyeCopies copies_;
};

}  // namespace hapton
