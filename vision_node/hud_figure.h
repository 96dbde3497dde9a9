#pragma once

#include <optional>
#include <string>
#include <string_view>

#include <vtkActor2D.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkRenderer.h>
#include <vtkTextActor.h>

#include "vision_node/depth_cues.h"
#include "vision_node/edge_pointer.h"
#include "vision_node/force_bar.h"
#include "vision_node/plot_figure.h"
#include "vision_node/stereo_camera.h"
#include "vision_node/time_line_figure.h"

namespace hapton {

// Lines of text in two corners of one eye's picture, and a notice in its middle: at the same position for both eyes, so they lie in the
// screen's plane. Lines that are too wide for the picture are broken (break_lines). RT: no.
class HudFigure {
 public:
  void add_to(vtkRenderer* renderer);
  void place(PictureSize size);
  void set(std::string_view facts, std::string_view help, std::string_view notice);
  // Shows the scale bar above the right end of the picture's lower edge; hides it if its length is zero.
  void set_scale_bar(const ScaleBar& bar, PictureSize size);
  void set_plots(const std::vector<PlotContent>& plots, PictureSize size) { plots_.set(plots, size, lift_px_ + help_px_); }
  // Shows the time line at the lower edge, with everything else above it; none: hides it. moment: share of the line, 0 to 1.
  void set_time_line(const std::optional<TimeLineShown>& line, double moment, PictureSize size);
  // Shows the force bar at the left edge; hides it if the limit is not known (0).
  void set_force(double force_n, double limit_n, PictureSize size) { force_.set(force_n, limit_n, size, small_font_px(size), lift_px_); }
  // Shows, at the picture's edge, where a probe outside the picture is; none: hides it.
  void set_pointer(const std::optional<EdgePointer>& pointer, PictureSize size);

 private:
  static int font_px(PictureSize size);
  static int small_font_px(PictureSize size);
  void show_texts();
  void show_text(vtkTextActor* actor, const std::string& text, double margin_px) const;

  // The texts as given to set(), before their lines are broken. width_px_: of the picture, 0: not known yet.
  std::string facts_text_;
  std::string help_text_;
  std::string notice_text_;
  int width_px_ = 0;
  vtkNew<vtkTextActor> facts_;
  vtkNew<vtkTextActor> help_;
  vtkNew<vtkTextActor> notice_;
  vtkNew<vtkTextActor> scale_label_;
  vtkNew<vtkActor2D> scale_;
  vtkNew<vtkPoints> scale_corners_;
  vtkNew<vtkTextActor> pointer_label_;
  vtkNew<vtkActor2D> pointer_;
  vtkNew<vtkPoints> pointer_corners_;
  PlotFigure plots_;
  ForceBar force_;
  TimeLineFigure time_line_;
  double lift_px_ = 0.0;  // height of the time line, above which the rest is drawn
  double help_px_ = 0.0;  // height of the help if its lines are broken, otherwise 0: what is at the right is then drawn above the help
};

}  // namespace hapton
