#pragma once

#include <vtkActor.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkRenderer.h>
#include <vtkUnsignedCharArray.h>

#include "vision_node/pen.h"
#include "vision_node/touch_menu.h"

namespace hapton {

// The menu as a panel in the world, with a depth like everything else: the entry at the tip is light, what the pen does now is marked.
// Hidden until first set. RT: no.
class MenuFigure {
 public:
  MenuFigure();
  void add_to(vtkRenderer* renderer);
  void set(const TouchMenu& menu, PenMode mode);

 private:
  vtkNew<vtkActor> panel_;
  vtkNew<vtkActor> labels_;
  vtkNew<vtkPolyData> fields_;
  vtkNew<vtkUnsignedCharArray> colours_;  // of the entries
};

}  // namespace hapton
