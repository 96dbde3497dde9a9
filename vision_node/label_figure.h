#pragma once

#include <vector>

#include <vtkNew.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkTextActor.h>

#include "vision_node/annotation_figure.h"
#include "vision_node/stereo_camera.h"

namespace hapton {

// Labels at points of the world, drawn into one eye's image: each at the pixel where that eye sees the point, so that the two eyes see the
// label at the point's depth. Threads: the window's. RT: no.
class LabelFigure {
 public:
  static constexpr std::size_t kMax = 16;  // labels that are shown; more would cover the scene

  void add_to(vtkRenderer* renderer);
  // Shows these labels and no others. Labels behind the eye, and those after the first kMax, are left out.
  void place(const std::vector<WorldLabel>& labels, const StereoScreen& screen, Eye eye, PictureSize size);

 private:
  std::vector<vtkSmartPointer<vtkTextActor>> texts_;
};

}  // namespace hapton
