#pragma once

#include <memory>

#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"
#include "vision_node/stereo_camera.h"

namespace hapton {

// The baseline of frames_bench: the program that a VTK user writes to see a mesh with two eyes. It has one window with two renderers side
// by side, and one mapper and one actor in both. The positions of the eyes, the pose of the scene, flat shading and one sample per pixel
// are those of StereoView, so both draw the same mesh from the same places. Everything else is VTK's default: lights, colours, no levels of
// detail, and cameras that are turned towards the middle of the picture instead of an off-axis projection. Frame: W. Units: m, pixels.
// Threads: one. RT: no.
class PlainVtkView {
 public:
  // mesh: is copied. window: size of the picture of both eyes together. offscreen: no window is mapped, but an X display is still needed.
  // Error: no display (vision_node/display.h).
  static Result<std::unique_ptr<PlainVtkView>> open(const TriangleMesh& mesh, const Framing& framing, PictureSize window, bool offscreen);
  ~PlainVtkView();

  void set_scene_pose(const Pose& X_WS);  // takes effect with the next draw()
  // Draws one frame and waits until the graphics driver is done.
  void draw();

 private:
  struct Window;
  explicit PlainVtkView(std::unique_ptr<Window> window);
  std::unique_ptr<Window> window_;
};

}  // namespace hapton
