#include "vision_node/annotation_figure.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include <vtkCellArray.h>
#include <vtkMatrix4x4.h>
#include <vtkPoints.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkShaderProperty.h>
#include <vtkUniforms.h>

#include "vision_node/vtk_shapes.h"

namespace hapton {
namespace {

const Vec3 kStrokeColour(0.10, 0.80, 1.0);
const Vec3 kMeasureColour(0.98, 0.98, 0.95);
// The width of lines in pixels is this share of the picture's height, and at least kMinWidthPx.
constexpr double kWidthShare = 1.0 / 240.0;
constexpr double kMinWidthPx = 2.0;
constexpr double kDotInWidths = 2.5;
constexpr double kMeasureInWidths = 0.7;
constexpr std::size_t kMaxLabels = 12;
// Lines are drawn nearer to the eye than they are: by this many pixels' widths at their depth, besides twice the strokes' bound.
constexpr double kLiftPx = 1.0;

// Polylines, and single points as dots.
class LineShape {
 public:
  void add(const std::vector<Vec3>& points) {
    if (points.empty()) return;
    std::vector<vtkIdType> ids;
    for (const Vec3& p : points) ids.push_back(points_->InsertNextPoint(p.data()));
    (points.size() > 1 ? lines_ : dots_)->InsertNextCell(static_cast<vtkIdType>(ids.size()), ids.data());
  }
  void add_dot(const Vec3& p) { add({p}); }

  // Shows the shape, or hides the actor if the shape is empty.
  void show_in(vtkActor* actor) {
    vtkNew<vtkPolyData> data;
    data->SetPoints(points_);
    data->SetLines(lines_);
    data->SetVerts(dots_);
    vtkPolyDataMapper::SafeDownCast(actor->GetMapper())->SetInputData(data);
    actor->SetVisibility(points_->GetNumberOfPoints() > 0);
  }

 private:
  static vtkSmartPointer<vtkPoints> make_points() {
    auto points = vtkSmartPointer<vtkPoints>::New();
    points->SetDataTypeToDouble();
    return points;
  }
  vtkSmartPointer<vtkPoints> points_ = make_points();
  vtkNew<vtkCellArray> lines_;
  vtkNew<vtkCellArray> dots_;
};

void set_up_line(vtkActor* actor, const Vec3& colour) {
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->ScalarVisibilityOff();
  actor->SetMapper(mapper);
  actor->GetProperty()->SetColor(colour.x(), colour.y(), colour.z());
  actor->GetProperty()->LightingOff();
  LineShape().show_in(actor);
}

// Moves each point towards the eye by `lift`: x, y and w of the clip coordinates stay, and z becomes that of the nearer depth. At the depth
// w along the viewing direction, z = a w + b, with b = -2 f n / (f - n), so z / w = a + b / w. At the depth w - lift, z / w is
// a + b / (w - lift). The z that gives this when it is divided by the unchanged w is a w + b + b lift / (w - lift).
void lift_lines(vtkActor* actor) {
  actor->GetShaderProperty()->AddVertexShaderReplacement(
      "//VTK::PositionVC::Impl", true,
      "//VTK::PositionVC::Impl\n"
      "  float inkLift = min(inkLiftM + inkLiftShare * gl_Position.w, 0.5 * gl_Position.w);\n"
      "  gl_Position.z -= inkLiftScale * inkLift / (gl_Position.w - inkLift);\n",
      false);
  vtkUniforms* uniforms = actor->GetShaderProperty()->GetVertexCustomUniforms();
  for (const char* name : {"inkLiftM", "inkLiftShare", "inkLiftScale"}) uniforms->SetUniformf(name, 0.0F);
}

void set_pose(vtkActor* actor, const Pose& X) {
  vtkNew<vtkMatrix4x4> matrix;
  copy_matrix(X.matrix(), matrix);
  actor->SetUserMatrix(matrix);
}

}  // namespace

std::string describe_length(double length_m) {
  if (length_m >= 1.0) return fmt::format("{:.4f} m", length_m);
  if (length_m >= 1e-4 || length_m == 0.0) return fmt::format("{:.2f} mm", 1e3 * length_m);
  return fmt::format("{:.3g} um", 1e6 * length_m);
}

AnnotationFigure::AnnotationFigure() {
  for (vtkActor* actor : {strokes_.Get(), held_strokes_.Get(), current_stroke_.Get()}) set_up_line(actor, kStrokeColour);
  for (vtkActor* actor : {measures_.Get(), hidden_measures_.Get()}) set_up_line(actor, kMeasureColour);
  for (vtkActor* actor : {strokes_.Get(), held_strokes_.Get(), current_stroke_.Get(), measures_.Get()}) lift_lines(actor);
  show_through(hidden_measures_);
}

void AnnotationFigure::add_to(vtkRenderer* renderer) {
  for (vtkActor* actor : actors()) renderer->AddActor(actor);
}

void AnnotationFigure::set_scene_pose(const Pose& X_WS) {
  if (X_WS.matrix() == X_WS_.matrix()) return;
  X_WS_ = X_WS;
  set_pose(strokes_, X_WS_);
  set_pose(current_stroke_, X_WS_);
  build_measures();
}

void AnnotationFigure::set_objects(ObjectPoses X_SO, std::int32_t held, const Pose& X_TO) {
  X_SO_ = std::move(X_SO);
  held_object_ = held;
  X_TO_ = X_TO;
  build_strokes();
  build_measures();
}

void AnnotationFigure::set_entries(const Annotations& annotations, std::size_t scene_objects) {
  annotations_ = &annotations;
  scene_objects_ = scene_objects;
  build_strokes();
  build_measures();
}

void AnnotationFigure::set_current_stroke(std::int32_t object, const std::vector<Vec3>* points_m) {
  LineShape shape;
  if (points_m != nullptr) {
    std::vector<Vec3> points_S;
    points_S.reserve(points_m->size());
    for (const Vec3& p_O : *points_m) points_S.push_back(hapton::place({object, p_O}, X_SO_));
    shape.add(points_S);
  }
  shape.show_in(current_stroke_);
}

void AnnotationFigure::set_first_end(const std::optional<AnnotationPoint>& first) {
  const bool had_one = std::exchange(first_end_, first).has_value();
  if (had_one || first_end_) build_measures();
}

void AnnotationFigure::set_probe(const ProbeShown& probe) {
  p_WP_ = probe.p_WP;
  X_WT_.translation() = probe.p_WP;
  X_WT_.linear() = probe.q_WP.toRotationMatrix();
  if (held_object_ >= 0) set_pose(held_strokes_, X_WT_);
  if (held_object_ >= 0 || first_end_) build_measures();
}

const std::vector<Annotation>& AnnotationFigure::entries() const {
  static const std::vector<Annotation> kNone;
  return annotations_ != nullptr ? annotations_->entries : kNone;
}

Vec3 AnnotationFigure::find_in_world(const AnnotationPoint& point) const {
  if (point.object == held_object_ && held_object_ >= 0) return X_WT_ * (X_TO_ * point.p_O);
  return X_WS_ * hapton::place(point, X_SO_);
}

void AnnotationFigure::build_strokes() {
  LineShape lines_in_scene;
  LineShape lines_in_hand;
  for (const Annotation& entry : entries()) {
    const auto* stroke = std::get_if<Stroke>(&entry);
    if (stroke == nullptr || !is_shown(stroke->object)) continue;
    const bool is_held = stroke->object == held_object_;
    std::vector<Vec3> points;
    points.reserve(stroke->points_m.size());
    for (const Vec3& p_O : stroke->points_m) points.push_back(is_held ? Vec3(X_TO_ * p_O) : hapton::place({stroke->object, p_O}, X_SO_));
    (is_held ? lines_in_hand : lines_in_scene).add(points);
  }
  lines_in_scene.show_in(strokes_);
  lines_in_hand.show_in(held_strokes_);
}

void AnnotationFigure::build_measures() {
  LineShape shape;
  const auto add = [&](const Vec3& from, const Vec3& to) {
    shape.add({from, to});
    shape.add_dot(from);
    shape.add_dot(to);
  };
  for (const Annotation& entry : entries()) {
    const auto* measure = std::get_if<Measure>(&entry);
    if (measure == nullptr || !is_shown(measure->ends[0].object) || !is_shown(measure->ends[1].object)) continue;
    add(find_in_world(measure->ends[0]), find_in_world(measure->ends[1]));
  }
  if (first_end_ && p_WP_) add(find_in_world(*first_end_), *p_WP_);
  shape.show_in(measures_);
  shape.show_in(hidden_measures_);
}

void AnnotationFigure::aim(const StereoScreen& screen, Eye eye, PictureSize size) {
  const EyeDepths depths = compute_eye_depths(screen, eye);
  const double scale = 2.0 * depths.far_m * depths.near_m / (depths.far_m - depths.near_m);
  // At the depth w, a pixel is w * screen.width_m / (depths.eye_m * size.width_px) wide.
  const double share = kLiftPx * screen.width_m / (depths.eye_m * size.width_px);
  for (vtkActor* actor : {strokes_.Get(), held_strokes_.Get(), current_stroke_.Get(), measures_.Get()}) {
    vtkUniforms* uniforms = actor->GetShaderProperty()->GetVertexCustomUniforms();
    uniforms->SetUniformf("inkLiftM", static_cast<float>(2.0 * bound_m_));
    uniforms->SetUniformf("inkLiftShare", static_cast<float>(share));
    uniforms->SetUniformf("inkLiftScale", static_cast<float>(scale));
  }
  const double width_px = std::max(kMinWidthPx, kWidthShare * size.height_px);
  for (vtkActor* actor : actors()) {
    const bool is_measure = actor == measures_.Get() || actor == hidden_measures_.Get();
    actor->GetProperty()->SetLineWidth(static_cast<float>(is_measure ? kMeasureInWidths * width_px : width_px));
    actor->GetProperty()->SetPointSize(static_cast<float>(kDotInWidths * width_px));
  }
}

std::vector<WorldLabel> AnnotationFigure::labels() const {
  std::vector<WorldLabel> labels;
  if (first_end_ && p_WP_) {
    const Vec3 from = find_in_world(*first_end_);
    labels.push_back({0.5 * (from + *p_WP_), describe_length((*p_WP_ - from).norm())});
  }
  for (auto entry = entries().rbegin(); entry != entries().rend() && labels.size() < kMaxLabels; ++entry) {
    const auto* measure = std::get_if<Measure>(&*entry);
    if (measure == nullptr || !is_shown(measure->ends[0].object) || !is_shown(measure->ends[1].object)) continue;
    const Vec3 from = find_in_world(measure->ends[0]);
    const Vec3 to = find_in_world(measure->ends[1]);
    const bool is_held = held_object_ >= 0 && (measure->ends[0].object == held_object_ || measure->ends[1].object == held_object_);
    labels.push_back({0.5 * (from + to), describe_length(is_held ? (to - from).norm() : compute_length_m(*measure, X_SO_))});
  }
  return labels;
}

}  // namespace hapton
