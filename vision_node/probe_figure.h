#pragma once

#include <array>

#include <vtkActor.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkRenderer.h>

#include "vision_node/probe_shown.h"

namespace hapton {

// The stylus with its ball tip, and the force arrow, as VTK actors. Hidden until first set. The arrow is seen from every side,
// also where it points into an object.
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
  // The arrow once more, over everything and with every other block of pixels left out: seen where it points into an object.
  vtkNew<vtkActor> ghost_shaft_;
  vtkNew<vtkActor> ghost_head_;

  std::array<vtkActor*, 7> actors() { return {stylus_, grip_, tip_, shaft_, head_, ghost_shaft_, ghost_head_}; }
};

}  // namespace hapton
