#pragma once

#include <array>
#include <vector>

#include <vtkActor2D.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkRenderer.h>
#include <vtkTextActor.h>

#include "vision_node/live_plots.h"
#include "vision_node/stereo_camera.h"

namespace hapton {

// Plots one above the other at the right of one eye's picture, in the screen's plane. All their lines are one actor, because each actor of
// the HUD costs as much as hundreds of lines; a background panel would cost more than all the plots where the CPU draws. RT: no.
class PlotFigure {
 public:
  static constexpr std::size_t kMax = 2;  // plots: the force, the age of the state

  void add_to(vtkRenderer* renderer);
  // Shows the plots, at most kMax of them; hides the figure if there are none.
  // lift_px: how much higher than usual they are.
  void set(const std::vector<PlotContent>& plots, PictureSize size, double lift_px = 0.0);

  // What is drawn, so that HeadsetPanel can draw it elsewhere. Pixels of the picture.
  bool is_shown() const { return line_actor_->GetVisibility() != 0; }
  vtkPolyData* lines() const { return lines_; }
  vtkTextActor* title(std::size_t plot) const { return titles_[plot]; }

 private:
  // The rectangle of one plot, in pixels of the picture.
  struct Frame {
    Vec2 low = Vec2::Zero();
    Vec2 size = Vec2::Zero();
    Vec2 at(const Vec2& share) const { return low + size.cwiseProduct(share); }
  };
  static Frame place(std::size_t plot, PictureSize size, double lift_px);

  std::vector<PlotContent> shown_plots_;
  PictureSize size_;
  double lift_px_ = 0.0;
  vtkNew<vtkPolyData> lines_;
  vtkNew<vtkActor2D> line_actor_;
  std::array<vtkNew<vtkTextActor>, kMax> titles_;
};

}  // namespace hapton
