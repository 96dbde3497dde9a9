#pragma once

#include <memory>

#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"
#include "vision_node/stereo_camera.h"

namespace hapton {

// The program that a VTK user writes to see a mesh with two eyes: one window, two renderers side by side, one mapper and one actor in both,
// everything else as VTK has it. It sees what our view sees: the same eyes, the same pose. Threads: all calls from one. RT: no.
class PlainVtkView {
 public:
  // Error: no display (vision_node/display.h).
  static Result<std::unique_ptr<PlainVtkView>> open(const TriangleMesh& mesh, const Framing& framing, PictureSize window, bool offscreen);
  ~PlainVtkView();

  void set_scene_pose(const Pose& X_WS);
  // Draws and waits until it is done.
  void draw();

 private:
  struct Window;
  explicit PlainVtkView(std::unique_ptr<Window> window);
  std::unique_ptr<Window> window_;
};

}  // namespace hapton
