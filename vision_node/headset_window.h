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
  // Pre: window outlives this and is initialised. is_mapped: the window is on the screen; otherwise size is the size of its image.
  HeadsetWindow(vtkOpenGLRenderWindow* window, bool is_mapped, PictureSize size) : window_(window), is_mapped_(is_mapped), size_(size) {}

  // From now on VTK draws two images of that size. Call it before each frame: after a resize of the window, VTK takes the window's size.
  void enter(PictureSize eye_size);
  // From now on VTK draws for the window; no effect if it already does.
  void leave();

  // Call it when a frame has been drawn: the calls below copy the images of that frame.
  void take_frame();
  void copy_eye(std::size_t eye, unsigned texture) { copies_.copy_to_texture(eye, texture); }
  // Shows the left eye's image in the window on the screen; no effect if there is no such window.
  void show_mirror();
  // The pixel of the left eye's image that is shown at that pixel of the window; outside the image if the window shows nothing there.
  Eigen::Vector2i find_pixel(int window_x_px, int window_y_px) const;

  GlxWindow handles();
  // Deletes its OpenGL objects. Pre: the context is current.
  void release() { copies_.release(); }

 private:
  PictureSize mapped_size() const;

  vtkOpenGLRenderWindow* window_;
  bool is_mapped_;
  PictureSize size_;
  PictureSize eye_size_;  // size of one eye's image; zero while VTK draws for the window
  EyeCopies copies_;
};

}  // namespace hapton
