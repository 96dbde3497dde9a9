#pragma once

#include <array>
#include <string_view>
#include <vector>

#include <vtkActor.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkRenderer.h>
#include <vtkTextActor.h>
#include <vtkTextActor3D.h>

#include "vision_node/force_bar.h"
#include "vision_node/plot_figure.h"

namespace hapton {

// The HUD for a headset, where nobody can read text in the corners of the picture: texts on plates stand upright behind the workspace,
// above its upper edge; the force bar is to the left of the workspace, and the curves are to the right. All have a depth like everything
// else. Positions: frame W, at scale 1:1. Threads: the window's. RT: no.
class HeadsetPanel {
 public:
  HeadsetPanel();
  void add_to(vtkRenderer* renderer);
  // An empty text is not shown.
  void set(std::string_view facts, std::string_view help, std::string_view notice);
  // Like ForceBar::set and PlotFigure::set: hidden if the limit is not known (0), or if there are no plots. Pre: finite.
  void set_force(double force_n, double limit_n);
  void set_plots(const std::vector<PlotContent>& plots);

 private:
  vtkNew<vtkTextActor3D> facts_;
  vtkNew<vtkTextActor3D> help_;
  vtkNew<vtkTextActor3D> notice_;
  ForceBar bar_;
  vtkNew<vtkPolyData> bar_shape_;  // the bar's rectangles, each nearer to the viewer than the one that it covers
  vtkNew<vtkActor> bar_actor_;
  vtkNew<vtkTextActor3D> bar_label_;
  PlotFigure plots_;
  vtkNew<vtkActor> plot_actor_;
  std::array<vtkNew<vtkTextActor3D>, PlotFigure::kMax> plot_titles_;
};

}  // namespace hapton
