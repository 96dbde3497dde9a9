#pragma once

#include <vtkActor.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkRenderer.h>

#include "vision_node/probe_shown.h"

namespace hapton {

// The stylus with its ball tip, and the force arrow, as VTK actors. Hidden until first set.
class ProbeFigure {
 public:
  explicit ProbeFigure(const ProbeSizes& sizes);
  void add_to(vtkRenderer* renderer);
  void set(const ProbeShown& probe);
  const ProbeSizes& sizes() const { return sizes_; }

 private:
  ProbeSizes sizes_;
  vtkNew<vtkActor> stylus_;
  vtkNew<vtkActor> grip_;
  vtkNew<vtkActor> tip_;
  vtkNew<vtkActor> shaft_;
  vtkNew<vtkActor> head_;
};

}  // namespace hapton
