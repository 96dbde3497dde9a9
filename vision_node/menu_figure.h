#pragma once

#include <vtkActor.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkRenderer.h>
#include <vtkUnsignedCharArray.h>

#include "vision_node/pen.h"
#include "vision_node/touch_menu.h"

namespace hapton {

// The menu as a panel in the world, with a depth like everything else. The entry at the tip and the entry of the pen's mode have colours
// of their own. Hidden while the menu is closed, and until set() is called. RT: no.
class MenuFigure {
 public:
  MenuFigure();
  void add_to(vtkRenderer* renderer);
  void set(const TouchMenu& menu, PenMode mode);

 private:
  vtkNew<vtkActor> panel_;
  vtkNew<vtkActor> labels_;
  vtkNew<vtkPolyData> fields_;
  vtkNew<vtkUnsignedCharArray> colours_;  // one for each entry
};

}  // namespace hapton
