#pragma once

#include <vtkActor2D.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkRenderer.h>
#include <vtkTextActor.h>

#include "vision_node/stereo_camera.h"

namespace hapton {

// An upright bar at the left edge of one eye's picture, in the screen's plane. Its filled part is the force as a share of the largest one
// that the device may get; that limit is written above the bar. Green, and red from kNearLimit on. RT: no.
class ForceBar {
 public:
  static constexpr double kNearLimit = 0.95;  // from this share on the device may not get the force that was computed

  void add_to(vtkRenderer* renderer);
  // Shows the force; hidden if the limit is not known (0). lift_px: height of what is drawn at the picture's lower edge. Pre: finite.
  void set(double force_n, double limit_n, PictureSize size, int font_px, double lift_px = 0.0);

  // What is drawn, so that HeadsetPanel can draw it elsewhere. Corners in pixels, four for each rectangle; those farther back come first.
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
