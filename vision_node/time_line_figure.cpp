#include "vision_node/time_line_figure.h"

#include <algorithm>
#include <array>

#include <vtkCellArray.h>
#include <vtkPointData.h>
#include <vtkPolyDataMapper2D.h>
#include <vtkProperty2D.h>
#include <vtkTextProperty.h>
#include <vtkUnsignedCharArray.h>

namespace hapton {
namespace {

using LineColour = std::array<unsigned char, 3>;
constexpr LineColour kTrack = {92, 98, 108};
constexpr LineColour kContactBand = {90, 230, 120};
constexpr LineColour kMarkerTick = {120, 200, 255};
constexpr LineColour kFaultTick = {240, 80, 70};
// Widths, pixels. A band narrower than kMinBand could not be seen.
constexpr double kMinBand = 1.0;
constexpr double kTickWidth = 2.0;

// Rectangles of several colours for one actor, so that all are drawn at once.
class ColouredBoxes {
 public:
  ColouredBoxes() { colours_->SetNumberOfComponents(3); }

  void add(const LineColour& colour, double left, double right, double bottom, double top) {
    const double corners[4][2] = {{left, bottom}, {right, bottom}, {right, top}, {left, top}};
    vtkIdType ids[4];
    for (int i = 0; i < 4; ++i) {
      ids[i] = points_->InsertNextPoint(corners[i][0], corners[i][1], 0.0);
      colours_->InsertNextTypedTuple(colour.data());
    }
    cells_->InsertNextCell(4, ids);
  }
  void show_in(vtkPolyData* shape) {
    shape->SetPoints(points_);
    shape->SetPolys(cells_);
    shape->GetPointData()->SetScalars(colours_);
  }

 private:
  vtkNew<vtkPoints> points_;
  vtkNew<vtkCellArray> cells_;
  vtkNew<vtkUnsignedCharArray> colours_;
};

}  // namespace

void TimeLineFigure::add_to(vtkRenderer* renderer) {
  vtkNew<vtkPolyDataMapper2D> mapper;
  mapper->SetInputData(shape_);
  line_->SetMapper(mapper);
  // The mark of the moment: a vertical post with a triangle at each end.
  moment_corners_->SetNumberOfPoints(10);
  vtkNew<vtkCellArray> cells;
  const vtkIdType post[4] = {0, 1, 2, 3};
  const vtkIdType above[3] = {4, 5, 6};
  const vtkIdType below[3] = {7, 8, 9};
  cells->InsertNextCell(4, post);
  cells->InsertNextCell(3, above);
  cells->InsertNextCell(3, below);
  vtkNew<vtkPolyData> shape;
  shape->SetPoints(moment_corners_);
  shape->SetPolys(cells);
  vtkNew<vtkPolyDataMapper2D> moment_mapper;
  moment_mapper->SetInputData(shape);
  moment_->SetMapper(moment_mapper);
  moment_->GetProperty()->SetColor(1.0, 1.0, 1.0);
  for (vtkTextActor* text : {begin_.Get(), end_.Get()}) {
    vtkTextProperty* style = text->GetTextProperty();
    style->SetFontFamilyToArial();
    style->SetColor(0.96, 0.97, 0.98);
    style->SetVerticalJustificationToCentered();
  }
  begin_->GetTextProperty()->SetJustificationToRight();
  for (vtkActor2D* actor : {line_.Get(), moment_.Get(), static_cast<vtkActor2D*>(begin_.Get()), static_cast<vtkActor2D*>(end_.Get())}) {
    actor->VisibilityOff();
    renderer->AddActor2D(actor);
  }
}

void TimeLineFigure::set(const std::optional<TimeLineShown>& line, double moment, PictureSize size) {
  for (vtkActor2D* actor : {line_.Get(), moment_.Get(), static_cast<vtkActor2D*>(begin_.Get()), static_cast<vtkActor2D*>(end_.Get())}) {
    actor->SetVisibility(line.has_value());
  }
  if (!line) return;
  const TimeLinePlace place = place_time_line(size);
  if (line != shown_line_ || size != size_) draw_line(*line, place);
  shown_line_ = line;
  size_ = size;
  draw_moment(moment, place);
}

void TimeLineFigure::draw_line(const TimeLineShown& line, const TimeLinePlace& place) {
  const auto x_of = [&](double share) { return place.left_px + share * place.width_px; };
  const double top = place.bottom_px + place.height_px;
  ColouredBoxes boxes;
  boxes.add(kTrack, x_of(0.0), x_of(1.0), place.bottom_px, top);
  for (const auto& band : line.contact) {
    const double from = x_of(band.from);
    boxes.add(kContactBand, from, std::max(x_of(band.to), from + kMinBand), place.bottom_px, top);
  }
  const double over = 0.35 * place.height_px;
  for (const bool is_fault : {false, true}) {  // faults last, so that no marker hides one
    for (const auto& tick : line.ticks) {
      if (tick.is_fault != is_fault) continue;
      const double x = x_of(tick.at);
      boxes.add(is_fault ? kFaultTick : kMarkerTick, x - 0.5 * kTickWidth, x + 0.5 * kTickWidth, place.bottom_px - over, top + over);
    }
  }
  boxes.show_in(shape_);
  const double middle = place.bottom_px + 0.5 * place.height_px;
  for (vtkTextActor* text : {begin_.Get(), end_.Get()})
    text->GetTextProperty()->SetFontSize(std::clamp(static_cast<int>(0.42 * place.strip_height_px), 9, 30));
  begin_->SetInput(line.begin.c_str());
  end_->SetInput(line.end.c_str());
  const double gap = 0.6 * place.height_px;
  begin_->SetPosition(place.left_px - gap, middle);
  end_->SetPosition(place.left_px + place.width_px + gap, middle);
}

void TimeLineFigure::draw_moment(double moment, const TimeLinePlace& place) {
  const double x = place.left_px + moment * place.width_px;
  const double over = 0.6 * place.height_px;
  const double low = place.bottom_px - over;
  const double high = place.bottom_px + place.height_px + over;
  const double corners[10][2] = {{x - 1.0, low},        {x + 1.0, low},         {x + 1.0, high},        {x - 1.0, high},
                                 {x, high - over},      {x + 0.8 * over, high}, {x - 0.8 * over, high}, {x, low + over},
                                 {x - 0.8 * over, low}, {x + 0.8 * over, low}};
  for (vtkIdType i = 0; i < 10; ++i) moment_corners_->SetPoint(i, corners[i][0], corners[i][1], 0.0);
  moment_corners_->Modified();
}

}  // namespace hapton
