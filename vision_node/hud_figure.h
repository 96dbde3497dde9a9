#pragma once

#include <string_view>

#include <vtkNew.h>
#include <vtkRenderer.h>
#include <vtkTextActor.h>

#include "vision_node/stereo_camera.h"

namespace hapton {

// Lines of text in two corners of one eye's picture: the same place in both eyes', so they lie in the screen's plane. RT: no.
class HudFigure {
 public:
  void add_to(vtkRenderer* renderer);
  void place(PictureSize size);
  void set(std::string_view facts, std::string_view help);

 private:
  vtkNew<vtkTextActor> facts_;
  vtkNew<vtkTextActor> help_;
};

}  // namespace hapton
