#include "vision_node/headset_panel.h"

#include <string>

#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkTextProperty.h>

#include "core/math/types.h"

namespace hapton {
namespace {

constexpr int kFontPx = 40;  // size of the letters in their image, whatever their size in the world
// A line of 6 mm appears as half a degree at 0.65 m, where the workspace is by default.
constexpr double kLineM = 0.006;
constexpr double kNoticeM = 0.012;
// The workspace of the memo is 0.267 x 0.19 x 0.381 m (docs/frames.md); scenes stay below its upper edge.
const Vec3 kFactsAt(-0.19, 0.11, -0.19);
const Vec3 kHelpAt(0.02, 0.11, -0.19);
const Vec3 kNoticeAt(0.0, 0.16, -0.10);

// Bar and curves are placed as in a picture of this size: the bar at its left edge, the curves at its right edge.
constexpr PictureSize kPanelSize = {400, 400};
constexpr int kBarFontPx = 12;
constexpr double kBarPixelM = 0.0006;   // the bar is 62 mm high
constexpr double kPlotPixelM = 0.0009;  // a curve is 122 mm wide
const Vec3 kBarAt(-0.189, -0.109, -0.19);
const Vec3 kPlotsAt(-0.082, -0.115, -0.19);
// Each rectangle is this much nearer to the viewer than the one that it covers.
constexpr double kRectangleGapPx = 0.5;

void set_up_panel(vtkActor* actor, vtkPolyData* shape, const Vec3& p_W, double pixel_m) {
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(shape);
  actor->SetMapper(mapper);
  actor->SetScale(pixel_m, pixel_m, pixel_m);
  actor->SetPosition(p_W.x(), p_W.y(), p_W.z());
  actor->GetProperty()->LightingOff();
  actor->GetProperty()->SetLineWidth(2.0F);
  actor->VisibilityOff();
}

// Shows the label `of`, which has a position in pixels of a flat picture, at the same place of the panel whose lower left corner is p_W.
void show_label(vtkTextActor3D* actor, vtkTextActor* label, const Vec3& p_W, double pixel_m) {
  const double* at = label->GetPosition();
  const double scale = pixel_m * label->GetTextProperty()->GetFontSize() / kFontPx;
  actor->SetScale(scale, scale, scale);
  actor->SetPosition(p_W.x() + pixel_m * at[0], p_W.y() + pixel_m * at[1], p_W.z());
  actor->GetTextProperty()->SetJustification(label->GetTextProperty()->GetJustification());
  actor->VisibilityOn();
  if (actor->GetInput() == nullptr || std::string_view(actor->GetInput()) != label->GetInput()) actor->SetInput(label->GetInput());
}

// Separates the rectangles in depth: in one plane they would flicker.
void separate_rectangles(vtkPolyData* from, vtkPolyData* to) {
  vtkNew<vtkPoints> points;
  for (vtkIdType i = 0; i < from->GetNumberOfPoints(); ++i) {
    const double* at = from->GetPoint(i);
    points->InsertNextPoint(at[0], at[1], kRectangleGapPx * static_cast<double>(i / 4));
  }
  to->ShallowCopy(from);
  to->SetPoints(points);
}

void place(vtkTextActor3D* text, const Vec3& p_W, double line_m) {
  const double scale = line_m / kFontPx;
  text->SetScale(scale, scale, scale);
  text->SetPosition(p_W.x(), p_W.y(), p_W.z());
  vtkTextProperty* style = text->GetTextProperty();
  style->SetFontFamilyToArial();
  style->SetFontSize(kFontPx);
  style->SetColor(0.96, 0.97, 0.98);
  style->SetBackgroundColor(0.03, 0.04, 0.06);
  style->SetBackgroundOpacity(0.8);
  text->VisibilityOff();
}

// A text is set only if it has changed: otherwise VTK would draw its letters again.
void show(vtkTextActor3D* actor, std::string_view text) {
  const std::string owned(text);
  actor->SetVisibility(!owned.empty());
  if (!owned.empty() && (actor->GetInput() == nullptr || owned != actor->GetInput())) actor->SetInput(owned.c_str());
}

}  // namespace

HeadsetPanel::HeadsetPanel() {
  place(facts_, kFactsAt, kLineM);
  place(help_, kHelpAt, kLineM);
  place(notice_, kNoticeAt, kNoticeM);
  notice_->GetTextProperty()->SetColor(1.0, 0.78, 0.10);
  notice_->GetTextProperty()->SetJustificationToCentered();
  set_up_panel(bar_actor_, bar_shape_, kBarAt, kBarPixelM);
  set_up_panel(plot_actor_, plots_.lines(), kPlotsAt, kPlotPixelM);
  place(bar_label_, kBarAt, kLineM);
  for (const auto& title : plot_titles_) place(title, kPlotsAt, kLineM);
}

void HeadsetPanel::add_to(vtkRenderer* renderer) {
  for (vtkTextActor3D* text : {facts_.Get(), help_.Get(), notice_.Get(), bar_label_.Get()}) renderer->AddActor(text);
  for (const auto& title : plot_titles_) renderer->AddActor(title);
  renderer->AddActor(bar_actor_);
  renderer->AddActor(plot_actor_);
}

void HeadsetPanel::set(std::string_view facts, std::string_view help, std::string_view notice) {
  show(facts_, facts);
  show(help_, help);
  show(notice_, notice);
}

void HeadsetPanel::set_force(double force_n, double limit_n) {
  bar_.set(force_n, limit_n, kPanelSize, kBarFontPx);
  bar_actor_->SetVisibility(bar_.is_shown());
  bar_label_->SetVisibility(bar_.is_shown());
  if (!bar_.is_shown()) return;
  separate_rectangles(bar_.shape(), bar_shape_);
  show_label(bar_label_, bar_.label(), kBarAt, kBarPixelM);
}

void HeadsetPanel::set_plots(const std::vector<PlotContent>& plots) {
  plots_.set(plots, kPanelSize);
  plot_actor_->SetVisibility(plots_.is_shown());
  for (std::size_t i = 0; i < plot_titles_.size(); ++i) {
    plot_titles_[i]->VisibilityOff();
    if (i < plots.size()) show_label(plot_titles_[i], plots_.title(i), kPlotsAt, kPlotPixelM);
  }
}

}  // namespace hapton
