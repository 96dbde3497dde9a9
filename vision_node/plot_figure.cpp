#include "vision_node/plot_figure.h"

#include <algorithm>
#include <initializer_list>

#include <vtkCellArray.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyDataMapper2D.h>
#include <vtkTextProperty.h>
#include <vtkUnsignedCharArray.h>

#include "vision_node/text_width.h"

namespace hapton {
namespace {

using Colour = std::array<unsigned char, 3>;
constexpr Colour kGridColour = {120, 126, 134};
constexpr Colour kLimitColour = {240, 80, 70};
constexpr std::array<Colour, PlotFigure::kMax> kCurveColours = {{{90, 230, 120}, {120, 200, 255}}};
// A curve has a gap where it has no value for longer than this.
constexpr double kGapS = 1.0;

// Lines of several colours, for one actor.
class ColouredLines {
 public:
  ColouredLines() {
    colours_->SetNumberOfComponents(3);
    colours_->SetName("colours");
  }

  void begin(const Colour& colour) {
    end();
    colour_ = colour;
  }
  void add(const Vec2& at) {
    line_.push_back(points_->InsertNextPoint(at.x(), at.y(), 0.0));
    colours_->InsertNextTypedTuple(colour_.data());
  }
  void add_line(const Colour& colour, std::initializer_list<Vec2> at) {
    begin(colour);
    for (const Vec2& each : at) add(each);
  }
  void show_in(vtkPolyData* shape) {
    end();
    shape->SetPoints(points_);
    shape->SetLines(cells_);
    shape->GetPointData()->SetScalars(colours_);
  }

 private:
  void end() {
    if (line_.size() > 1) cells_->InsertNextCell(static_cast<vtkIdType>(line_.size()), line_.data());
    line_.clear();
  }

  vtkNew<vtkPoints> points_;
  vtkNew<vtkCellArray> cells_;
  vtkNew<vtkUnsignedCharArray> colours_;
  std::vector<vtkIdType> line_;
  Colour colour_ = kGridColour;
};

// Adds the frame, a line at half of the scale, the limit and the curve. at: finds the place in the picture from shares of the frame.
template <class At>
void add_curve(const PlotContent& plot, const Colour& colour, At&& at, ColouredLines& lines) {
  lines.add_line(kGridColour, {at(0, 0), at(1, 0), at(1, 1), at(0, 1), at(0, 0)});
  lines.add_line(kGridColour, {at(0, 0.5), at(1, 0.5)});
  if (plot.limit > 0.0) lines.add_line(kLimitColour, {at(0, plot.limit / plot.top), at(1, plot.limit / plot.top)});
  lines.begin(colour);
  double last_age_s = RecentCurve::kSeconds;
  for (const CurvePoint& point : plot.points) {
    if (last_age_s - point.age_s > kGapS) lines.begin(colour);
    last_age_s = point.age_s;
    lines.add(at(1.0 - point.age_s / RecentCurve::kSeconds, std::clamp(point.value / plot.top, 0.0, 1.0)));
  }
}

}  // namespace

void PlotFigure::add_to(vtkRenderer* renderer) {
  vtkNew<vtkPolyDataMapper2D> mapper;
  mapper->SetInputData(lines_);
  line_actor_->SetMapper(mapper);
  line_actor_->VisibilityOff();
  renderer->AddActor2D(line_actor_);
  for (const auto& title : titles_) {
    vtkTextProperty* style = title->GetTextProperty();
    style->SetFontFamilyToArial();
    style->SetColor(0.96, 0.97, 0.98);
    title->VisibilityOff();
    renderer->AddActor2D(title);
  }
}

// The plots are above the scale bar and its label, with the first plot on top.
PlotFigure::Frame PlotFigure::place(std::size_t plot, PictureSize size, double lift_px) {
  const double edge = 0.03 * std::min(size.width_px, size.height_px);
  const Vec2 each(0.34 * size.width_px, 0.13 * size.height_px);
  const double above = static_cast<double>(kMax - 1 - plot) * (each.y() + 1.6 * edge);
  return {Vec2(size.width_px - edge - each.x(), 6.0 * edge + lift_px + above), each};
}

void PlotFigure::set(const std::vector<PlotContent>& plots, PictureSize size, double lift_px) {
  const bool is_shown = !plots.empty();
  line_actor_->SetVisibility(is_shown);
  for (const auto& title : titles_) title->SetVisibility(is_shown);
  if (!is_shown || (plots == shown_plots_ && size == size_ && lift_px == lift_px_)) return;
  shown_plots_ = plots;
  size_ = size;
  lift_px_ = lift_px;
  ColouredLines lines;
  for (std::size_t i = 0; i < std::min(plots.size(), kMax); ++i) {
    const Frame frame = place(i, size, lift_px);
    add_curve(
        plots[i], kCurveColours[i],
        [&](double x, double y) {
          return frame.at({x, y});
        },
        lines);
    vtkTextProperty* style = titles_[i]->GetTextProperty();
    style->SetFontSize(std::clamp(std::min(size.width_px / 52, size.height_px / 52), 9, 32));
    // A title that is wider than its frame begins to the left of the frame, and ends at the frame's right edge.
    const bool is_wide = measure_text_width_px(style, plots[i].title) > frame.size.x();
    is_wide ? style->SetJustificationToRight() : style->SetJustificationToLeft();
    titles_[i]->SetPosition(frame.at({is_wide ? 1.0 : 0.0, 1}).x(), frame.at({0, 1}).y() + 3.0);
    // A text is set only if it has changed: otherwise VTK would draw its letters again.
    if (titles_[i]->GetInput() == nullptr || plots[i].title != titles_[i]->GetInput()) titles_[i]->SetInput(plots[i].title.c_str());
  }
  lines.show_in(lines_);
}

}  // namespace hapton
