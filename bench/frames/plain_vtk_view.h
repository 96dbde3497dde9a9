#pragma once

#include <memory>

#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"
#include "vision_node/stereo_camera.h"

namespace hapton {

// The program that a VTK user writes to see a mesh with two eyes: one window, two renderers side by side, one mapper and one actor in both.
// The eyes, the pose, flat shading and one sample a pixel are those of StereoView, so that both draw the same picture; everything else is
// VTK's default. Frame: W. Units: m, pixels. Threads: one. RT: no.
class PlainVtkView {
 public:
  // mesh: is copied. window: size of the picture of both eyes together. Error: no display (vision_node/display.h).
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
