#pragma once

#include <string_view>

#include <vtkNew.h>
#include <vtkRenderer.h>
#include <vtkTextActor3D.h>

namespace hapton {

// The texts of the HUD for a headset, in whose corners nobody can read: on plates that stand upright behind the workspace, above its upper
// edge, with a depth like everything else. Frame W, where the scale is 1:1. Threads: the window's. RT: no.
class HeadsetPanel {
 public:
  HeadsetPanel();
  void add_to(vtkRenderer* renderer);
  // An empty text is not shown.
  void set(std::string_view facts, std::string_view help, std::string_view notice);

 private:
  vtkNew<vtkTextActor3D> facts_;
  vtkNew<vtkTextActor3D> help_;
  vtkNew<vtkTextActor3D> notice_;
};

}  // namespace hapton
