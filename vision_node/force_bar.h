#pragma once

#include <vtkActor2D.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkRenderer.h>
#include <vtkTextActor.h>

#include "vision_node/stereo_camera.h"

namespace hapton {

// An upright bar at the left edge of one eye's picture, in the screen's plane: the force as a share of the largest that the device may get,
// which stands above it. Green, and red from kNearLimit on. RT: no.
class ForceBar {
 public:
  static constexpr double kNearLimit = 0.95;  // from here on the device may not get the force that was computed

  void add_to(vtkRenderer* renderer);
  // Hidden where the limit is not known (0). lift_px: what is at the lower edge. Pre: finite.
  void set(double force_n, double limit_n, PictureSize size, int font_px, double lift_px = 0.0);

  // What is drawn, for another place of it (HeadsetPanel): corners in pixels, four for each rectangle, the farther ones first.
  bool is_shown() const { return is_shown_; }
  vtkPolyData* shape() const { return shape_; }
  vtkTextActor* label() const { return limit_; }

 private:
  bool is_shown_ = false;
  vtkNew<vtkPolyData> shape_;
  vtkNew<vtkActor2D> bar_;
  vtkNew<vtkTextActor> limit_;
};

}  // namespace hapton
