#pragma once

#include <array>

#include <vtkActor.h>
#include <vtkActor2D.h>
#include <vtkNew.h>
#include <vtkRenderer.h>
#include <vtkTextActor.h>

#include "vision_node/teach_shapes.h"

namespace hapton {

// The shapes of a teaching view as VTK actors, and the scale of their colours at the left edge of each picture. Triangles are drawn
// a little nearer to the eye than the surface that they lie on, and lines nearer still; the scene hides what is behind it. RT: no.
class TeachFigure {
 public:
  TeachFigure();
  void add_to(vtkRenderer* renderer);
  void set_scene_pose(const Pose& X_WS);
  void set(const TeachShapes& shapes);
  void hide();

 private:
  void set_lines(const TeachShapes& shapes);
  void set_triangles(const TeachShapes& shapes);
  void set_legend(const std::optional<TeachLegend>& legend);

  vtkNew<vtkActor> lines_;
  vtkNew<vtkActor> triangles_;
  vtkNew<vtkActor2D> scale_;
  std::array<vtkNew<vtkTextActor>, 3> labels_;
};

}  // namespace hapton
