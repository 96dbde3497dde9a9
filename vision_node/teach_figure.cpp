#include "vision_node/teach_figure.h"

#include <fmt/format.h>

#include <vtkCellArray.h>
#include <vtkCoordinate.h>
#include <vtkMatrix4x4.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkPolyDataMapper2D.h>
#include <vtkProperty.h>
#include <vtkTextProperty.h>
#include <vtkUnsignedCharArray.h>

#include "vision_node/vtk_shapes.h"

namespace hapton {
namespace {

// Position and size of the scale of colours, as shares of the picture; and its number of steps.
constexpr double kScaleLeft = 0.02;
constexpr double kScaleWidth = 0.015;
constexpr double kScaleLow = 0.35;
constexpr double kScaleHigh = 0.70;
constexpr int kScaleSteps = 32;

// Points for one actor, each point with its own colour.
class ColouredPoints {
 public:
  ColouredPoints() { colours_->SetNumberOfComponents(3); }
  vtkIdType add(const Vec3& p, const TeachColour& colour) {
    colours_->InsertNextTypedTuple(colour.data());
    return points_->InsertNextPoint(p.data());
  }
  void give_to(vtkPolyData* shape) {
    shape->SetPoints(points_);
    shape->GetPointData()->SetScalars(colours_);
  }

 private:
  vtkNew<vtkPoints> points_;
  vtkNew<vtkUnsignedCharArray> colours_;
};

void set_up_unlit_actor(vtkActor* actor) {
  vtkNew<vtkPolyDataMapper> mapper;
  vtkNew<vtkPolyData> nothing;
  mapper->SetInputData(nothing);
  actor->SetMapper(mapper);
  actor->GetProperty()->LightingOff();
  actor->VisibilityOff();
}

}  // namespace

TeachFigure::TeachFigure() {
  set_up_unlit_actor(lines_);
  set_up_unlit_actor(triangles_);
  lines_->GetProperty()->SetLineWidth(1.0F);
  lines_->GetMapper()->SetResolveCoincidentTopologyToPolygonOffset();
  lines_->GetMapper()->SetRelativeCoincidentTopologyLineOffsetParameters(-4.0, -4.0);
  // The triangles lie on the surface of the scene: they are drawn nearer than it, by more than the resolution of the depth buffer.
  triangles_->GetMapper()->SetResolveCoincidentTopologyToPolygonOffset();
  triangles_->GetMapper()->SetRelativeCoincidentTopologyPolygonOffsetParameters(-2.0, -2.0);
  vtkNew<vtkPolyDataMapper2D> mapper;
  vtkNew<vtkCoordinate> shares;
  shares->SetCoordinateSystemToNormalizedViewport();
  mapper->SetTransformCoordinate(shares);
  vtkNew<vtkPolyData> shape;
  ColouredPoints corners;
  vtkNew<vtkCellArray> cells;
  for (int i = 0; i <= kScaleSteps; ++i) {
    const double share = static_cast<double>(i) / kScaleSteps;
    const double y = kScaleLow + share * (kScaleHigh - kScaleLow);
    const TeachColour colour = curvature_colour(2.0 * share - 1.0, 1.0);
    const vtkIdType left = corners.add({kScaleLeft, y, 0.0}, colour);
    corners.add({kScaleLeft + kScaleWidth, y, 0.0}, colour);
    if (i == 0) continue;
    const vtkIdType cell[4] = {left - 2, left - 1, left + 1, left};
    cells->InsertNextCell(4, cell);
  }
  corners.give_to(shape);
  shape->SetPolys(cells);
  mapper->SetInputData(shape);
  scale_->SetMapper(mapper);
  scale_->VisibilityOff();
  for (std::size_t i = 0; i < labels_.size(); ++i) {
    vtkTextActor* label = labels_[i];
    label->GetTextProperty()->SetFontFamilyToArial();
    label->GetTextProperty()->SetColor(0.96, 0.97, 0.98);
    label->GetTextProperty()->SetFontSize(14);
    label->GetTextProperty()->SetVerticalJustificationToCentered();
    label->GetPositionCoordinate()->SetCoordinateSystemToNormalizedViewport();
    label->SetPosition(kScaleLeft + 1.5 * kScaleWidth, kScaleLow + 0.5 * static_cast<double>(i) * (kScaleHigh - kScaleLow));
    label->VisibilityOff();
  }
}

void TeachFigure::add_to(vtkRenderer* renderer) {
  renderer->AddActor(triangles_);
  renderer->AddActor(lines_);
  renderer->AddActor2D(scale_);
  for (const auto& label : labels_) renderer->AddActor2D(label);
}

void TeachFigure::set_scene_pose(const Pose& X_WS) {
  vtkNew<vtkMatrix4x4> matrix;
  copy_matrix(X_WS.matrix(), matrix);
  lines_->SetUserMatrix(matrix);
  triangles_->SetUserMatrix(matrix);
}

void TeachFigure::hide() { set({}); }

void TeachFigure::set(const TeachShapes& shapes) {
  set_lines(shapes);
  set_triangles(shapes);
  set_legend(shapes.legend);
}

void TeachFigure::set_lines(const TeachShapes& shapes) {
  lines_->SetVisibility(!shapes.lines.empty());
  if (shapes.lines.empty()) return;
  ColouredPoints points;
  vtkNew<vtkCellArray> cells;
  for (const TeachLine& line : shapes.lines) {
    const vtkIdType ends[2] = {points.add(line.from, line.colour), points.add(line.to, line.colour)};
    cells->InsertNextCell(2, ends);
  }
  vtkNew<vtkPolyData> shape;
  points.give_to(shape);
  shape->SetLines(cells);
  vtkPolyDataMapper::SafeDownCast(lines_->GetMapper())->SetInputData(shape);
}

void TeachFigure::set_triangles(const TeachShapes& shapes) {
  triangles_->SetVisibility(!shapes.triangles.empty());
  if (shapes.triangles.empty()) return;
  ColouredPoints points;
  vtkNew<vtkCellArray> cells;
  for (const TeachTriangle& triangle : shapes.triangles) {
    vtkIdType ids[3];
    for (std::size_t k = 0; k < 3; ++k) ids[k] = points.add(triangle.corner[k], triangle.colour[k]);
    cells->InsertNextCell(3, ids);
  }
  vtkNew<vtkPolyData> shape;
  points.give_to(shape);
  shape->SetPolys(cells);
  vtkPolyDataMapper::SafeDownCast(triangles_->GetMapper())->SetInputData(shape);
}

void TeachFigure::set_legend(const std::optional<TeachLegend>& legend) {
  scale_->SetVisibility(legend.has_value());
  for (const auto& label : labels_) label->SetVisibility(legend.has_value());
  if (!legend) return;
  for (std::size_t i = 0; i < labels_.size(); ++i) {
    labels_[i]->SetInput(fmt::format("{:.3g} {}", (static_cast<double>(i) - 1.0) * legend->limit, legend->unit).c_str());
  }
}

}  // namespace hapton
