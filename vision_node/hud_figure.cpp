#include "vision_node/hud_figure.h"

#include <algorithm>
#include <string>

#include <vtkCellArray.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper2D.h>
#include <vtkProperty2D.h>
#include <vtkTextProperty.h>

#include "vision_node/line_breaks.h"
#include "vision_node/text_width.h"

namespace hapton {
namespace {

// Height of the notice, as a share of the picture's height: below the lines of text in the corner, above what the person looks at.
constexpr double kNoticeHeight = 0.79;
constexpr double kLineSpacing = 1.15;

// A text is set only if it has changed: otherwise VTK would draw its letters again.
void set_text(vtkTextActor* actor, std::string_view text) {
  const std::string owned(text);
  actor->SetVisibility(!owned.empty());
  if (!owned.empty() && (actor->GetInput() == nullptr || owned != actor->GetInput())) actor->SetInput(owned.c_str());
}

}  // namespace

void HudFigure::add_to(vtkRenderer* renderer) {
  for (vtkTextActor* text : {facts_.Get(), help_.Get(), notice_.Get(), scale_label_.Get(), pointer_label_.Get()}) {
    vtkTextProperty* style = text->GetTextProperty();
    style->SetFontFamilyToArial();
    style->SetColor(0.96, 0.97, 0.98);
    style->SetBackgroundColor(0.03, 0.04, 0.06);
    style->SetBackgroundOpacity(0.45);
    style->SetLineSpacing(kLineSpacing);
    text->SetVisibility(false);
    renderer->AddActor2D(text);
  }
  facts_->GetTextProperty()->SetVerticalJustificationToTop();
  vtkTextProperty* warning = notice_->GetTextProperty();
  warning->SetColor(1.0, 0.78, 0.10);
  warning->SetBackgroundOpacity(0.8);
  warning->SetJustificationToCentered();
  warning->SetVerticalJustificationToCentered();
  scale_label_->GetTextProperty()->SetJustificationToCentered();
  scale_label_->GetTextProperty()->SetBackgroundOpacity(0.0);
  // The scale bar: a line with a short upright line at each end.
  scale_corners_->SetNumberOfPoints(6);
  vtkNew<vtkCellArray> lines;
  for (vtkIdType i = 0; i < 6; i += 2) {
    const vtkIdType ends[2] = {i, i + 1};
    lines->InsertNextCell(2, ends);
  }
  vtkNew<vtkPolyData> shape;
  shape->SetPoints(scale_corners_);
  shape->SetLines(lines);
  vtkNew<vtkPolyDataMapper2D> mapper;
  mapper->SetInputData(shape);
  scale_->SetMapper(mapper);
  scale_->GetProperty()->SetColor(0.96, 0.97, 0.98);
  scale_->GetProperty()->SetLineWidth(2.0F);
  scale_->VisibilityOff();
  renderer->AddActor2D(scale_);
  pointer_label_->GetTextProperty()->SetJustificationToCentered();
  pointer_label_->GetTextProperty()->SetVerticalJustificationToCentered();
  pointer_corners_->SetNumberOfPoints(3);
  vtkNew<vtkCellArray> triangle;
  const vtkIdType corners[3] = {0, 1, 2};
  triangle->InsertNextCell(3, corners);
  vtkNew<vtkPolyData> head;
  head->SetPoints(pointer_corners_);
  head->SetPolys(triangle);
  vtkNew<vtkPolyDataMapper2D> head_mapper;
  head_mapper->SetInputData(head);
  pointer_->SetMapper(head_mapper);
  pointer_->GetProperty()->SetColor(1.0, 0.78, 0.10);
  pointer_->VisibilityOff();
  renderer->AddActor2D(pointer_);
  plots_.add_to(renderer);
  time_line_.add_to(renderer);
  force_.add_to(renderer);
}

void HudFigure::set_time_line(const std::optional<TimeLineShown>& line, double moment, PictureSize size) {
  const double lift_px = line ? place_time_line(size).strip_height_px : 0.0;
  if (lift_px != lift_px_) {
    lift_px_ = lift_px;
    place(size);
  }
  time_line_.set(line, moment, size);
}

void HudFigure::set_pointer(const std::optional<EdgePointer>& pointer, PictureSize size) {
  pointer_->SetVisibility(pointer.has_value());
  set_text(pointer_label_, pointer ? pointer->label : "");
  if (!pointer) return;
  const double length = 0.03 * std::min(size.width_px, size.height_px);
  const Vec2 along = length * pointer->towards;
  const Vec2 across(-0.5 * along.y(), 0.5 * along.x());
  const Vec2 corners[3] = {pointer->at_px + along, pointer->at_px + across, pointer->at_px - across};
  for (vtkIdType i = 0; i < 3; ++i) pointer_corners_->SetPoint(i, corners[i].x(), corners[i].y(), 0.0);
  pointer_corners_->Modified();
  // Moves the label farther inside the picture, to make room for the width of its text.
  const Vec2 label = pointer->at_px - 1.5 * along - Vec2(2.5 * length * pointer->towards.x(), 0.0);
  pointer_label_->SetPosition(label.x(), label.y());
}

void HudFigure::set_scale_bar(const ScaleBar& bar, PictureSize size) {
  const bool shown = bar.length_m > 0.0;
  set_text(scale_label_, shown ? bar.label : "");
  scale_->SetVisibility(shown);
  if (!shown) return;
  const double edge = 0.03 * std::min(size.width_px, size.height_px);
  const double to = size.width_px - edge;
  const double from = to - bar.pixels;
  const double y = 4.0 * edge + lift_px_ + help_px_;
  const double end = 0.25 * edge;
  const double corners[6][2] = {{from, y}, {to, y}, {from, y - end}, {from, y + end}, {to, y - end}, {to, y + end}};
  for (vtkIdType i = 0; i < 6; ++i) scale_corners_->SetPoint(i, corners[i][0], corners[i][1], 0.0);
  scale_corners_->Modified();
  scale_label_->SetPosition(0.5 * (from + to), y + end);
}

int HudFigure::font_px(PictureSize size) { return std::clamp(std::min(size.width_px / 44, size.height_px / 46), 9, 40); }

int HudFigure::small_font_px(PictureSize size) { return std::max(9, font_px(size) - 2); }

void HudFigure::place(PictureSize size) {
  const int font = font_px(size);
  const int edge = font / 2;
  facts_->GetTextProperty()->SetFontSize(font);
  for (vtkTextActor* text : {help_.Get(), scale_label_.Get(), pointer_label_.Get()})
    text->GetTextProperty()->SetFontSize(small_font_px(size));
  notice_->GetTextProperty()->SetFontSize(std::clamp(std::min(size.width_px / 46, size.height_px / 30), 9, 64));
  notice_->SetPosition(0.5 * size.width_px, kNoticeHeight * size.height_px);
  facts_->SetPosition(edge, size.height_px - edge);
  help_->SetPosition(edge, edge + lift_px_);
  width_px_ = size.width_px;
  show_texts();
}

void HudFigure::show_text(vtkTextActor* actor, const std::string& text, double margin_px) const {
  const auto fits = [&](std::string_view line) {
    return width_px_ == 0 || measure_text_width_px(actor->GetTextProperty(), line) <= width_px_ - 2.0 * margin_px;
  };
  set_text(actor, break_lines(text, fits));
}

void HudFigure::show_texts() {
  const double edge = facts_->GetPosition()[0];
  show_text(facts_, facts_text_, edge);
  show_text(help_, help_text_, edge);
  show_text(notice_, notice_text_, edge);
  const std::string shown = help_->GetInput() != nullptr ? help_->GetInput() : "";
  const bool is_broken = !help_text_.empty() && shown != help_text_;
  const auto lines = static_cast<double>(1 + std::count(shown.begin(), shown.end(), '\n'));
  help_px_ = is_broken ? lines * kLineSpacing * help_->GetTextProperty()->GetFontSize() : 0.0;
}

void HudFigure::set(std::string_view facts, std::string_view help, std::string_view notice) {
  if (facts == facts_text_ && help == help_text_ && notice == notice_text_) return;
  facts_text_ = facts;
  help_text_ = help;
  notice_text_ = notice;
  show_texts();
}

}  // namespace hapton
