#pragma once

#include <vector>

#include <vtkNew.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkTextActor.h>

#include "vision_node/annotation_figure.h"
#include "vision_node/stereo_camera.h"

namespace hapton {

// Texts at points of the world, in one eye's picture: each where that eye sees the point, so the two eyes see it at the point's depth. RT:
// no.
class LabelFigure {
 public:
  static constexpr std::size_t kMost = 16;

  void add_to(vtkRenderer* renderer);
  // Labels behind the eye, and more than kMost, are left out.
  void place(const std::vector<InkLabel>& labels, const StereoScreen& screen, Eye eye, PictureSize size);

 private:
  std::vector<vtkSmartPointer<vtkTextActor>> texts_;
};

}  // namespace hapton
