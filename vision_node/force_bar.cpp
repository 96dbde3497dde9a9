#include "vision_node/force_bar.h"

#include <algorithm>
#include <array>
#include <string>

#include <fmt/format.h>

#include <vtkCellArray.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyDataMapper2D.h>
#include <vtkTextProperty.h>
#include <vtkUnsignedCharArray.h>

namespace hapton {
namespace {

using BarColour = std::array<unsigned char, 3>;
constexpr BarColour kBarBackground = {14, 17, 22};
constexpr BarColour kBarFrame = {120, 126, 134};
constexpr BarColour kForceColour = {90, 230, 120};     // as the curve of the force in the plots
constexpr BarColour kNearLimitColour = {240, 80, 70};  // as the limit of the force in the plots
// Shares of the picture's height: the bar stands between the lines of text in the upper and in the lower corner.
constexpr double kBarLow = 0.37;
constexpr double kBarHeight = 0.26;
constexpr double kWidthInLetters = 0.8;

// Three rectangles of four corners each: background, force, frame.
class BarShape {
 public:
  BarShape() {
    colours_->SetNumberOfComponents(3);
    colours_->SetName("colours");
  }
  std::array<vtkIdType, 5> add(const Vec2& low, const Vec2& high, const BarColour& colour) {
    std::array<vtkIdType, 5> ids = {};
    const Vec2 corners[4] = {low, {high.x(), low.y()}, high, {low.x(), high.y()}};
    for (std::size_t i = 0; i < 4; ++i) {
      ids[i] = points_->InsertNextPoint(corners[i].x(), corners[i].y(), 0.0);
      colours_->InsertNextTypedTuple(colour.data());
    }
    ids[4] = ids[0];
    return ids;
  }
  void fill(const Vec2& low, const Vec2& high, const BarColour& colour) { faces_->InsertNextCell(4, add(low, high, colour).data()); }
  void outline(const Vec2& low, const Vec2& high, const BarColour& colour) { lines_->InsertNextCell(5, add(low, high, colour).data()); }
  void show_in(vtkPolyData* shape) {
    shape->SetPoints(points_);
    shape->SetPolys(faces_);
    shape->SetLines(lines_);
    shape->GetPointData()->SetScalars(colours_);
  }

 private:
  vtkNew<vtkPoints> points_;
  vtkNew<vtkCellArray> faces_;
  vtkNew<vtkCellArray> lines_;
  vtkNew<vtkUnsignedCharArray> colours_;
};

}  // namespace

void ForceBar::add_to(vtkRenderer* renderer) {
  vtkNew<vtkPolyDataMapper2D> mapper;
  mapper->SetInputData(shape_);
  bar_->SetMapper(mapper);
  bar_->VisibilityOff();
  renderer->AddActor2D(bar_);
  vtkTextProperty* style = limit_->GetTextProperty();
  style->SetFontFamilyToArial();
  style->SetColor(0.96, 0.97, 0.98);
  limit_->VisibilityOff();
  renderer->AddActor2D(limit_);
}

void ForceBar::set(double force_n, double limit_n, PictureSize size, int font_px, double lift_px) {
  is_shown_ = limit_n > 0.0;
  bar_->SetVisibility(is_shown_);
  limit_->SetVisibility(is_shown_);
  if (!is_shown_) return;
  const double share = std::clamp(force_n / limit_n, 0.0, 1.0);
  const Vec2 low(0.5 * font_px, kBarLow * size.height_px + 0.5 * lift_px);
  const Vec2 high = low + Vec2(kWidthInLetters * font_px, kBarHeight * size.height_px);
  BarShape shape;
  shape.fill(low, high, kBarBackground);
  shape.fill(low, {high.x(), low.y() + share * (high.y() - low.y())}, share < kNearLimit ? kForceColour : kNearLimitColour);
  shape.outline(low, high, kBarFrame);
  shape.show_in(shape_);
  const std::string text = fmt::format("{:.3g} N", limit_n);
  if (limit_->GetInput() == nullptr || text != limit_->GetInput()) limit_->SetInput(text.c_str());
  limit_->GetTextProperty()->SetFontSize(font_px);
  limit_->SetPosition(low.x(), high.y() + 0.3 * font_px);
}

}  // namespace hapton
