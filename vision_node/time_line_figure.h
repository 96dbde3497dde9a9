#pragma once

#include <optional>

#include <vtkActor2D.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkRenderer.h>
#include <vtkTextActor.h>

#include "vision_node/time_line.h"

namespace hapton {

// The time line in one eye's image, in the plane of the screen: contact is green, markers blue, faults red, the shown moment white. RT: no.
class TimeLineFigure {
 public:
  void add_to(vtkRenderer* renderer);
  // line: none hides the figure. moment: position of the shown moment, 0 (begin) to 1 (end). size: of the image, pixels.
  void set(const std::optional<TimeLineShown>& line, double moment, PictureSize size);

 private:
  void draw_line(const TimeLineShown& line, const TimeLinePlace& place);
  void draw_moment(double moment, const TimeLinePlace& place);

  std::optional<TimeLineShown> shown_line_;
  PictureSize size_;
  vtkNew<vtkPolyData> shape_;
  vtkNew<vtkActor2D> line_;
  vtkNew<vtkPoints> moment_corners_;
  vtkNew<vtkActor2D> moment_;
  vtkNew<vtkTextActor> begin_;
  vtkNew<vtkTextActor> end_;
};

}  // namespace hapton
