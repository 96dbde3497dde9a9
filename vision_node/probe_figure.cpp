#include "vision_node/probe_figure.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include <vtkMapper.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>

#include "vision_node/depth_cues.h"
#include "vision_node/vtk_shapes.h"

namespace hapton {
namespace {

constexpr double kHeadToShaftRadius = 2.6;  // of the arrow's head; these three: free choices, in radii of the shaft
constexpr double kHeadLengthInRadii = 7.0;
constexpr double kLimitToShaftRadius = 3.2;
// Radius of the shadow in radii of the tip: a shadow as small as the tip of a point probe would not be seen.
constexpr double kShadowInRadii = 2.0;
// From the middle of the tip to the beginning of the arrow, in radii of the tip.
constexpr double kGapInRadii = 1.8;
// Share of the depth range, at its near end, for the tip's ghost: smaller than that of the arrow, so that the tip is in front.
constexpr double kTipShare = 5e-4;

void set_up_actor(vtkActor* actor, vtkPolyData* shape, const Vec3& colour, double ambient, double specular) {
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(shape);
  mapper->ScalarVisibilityOff();
  actor->SetMapper(mapper);
  vtkProperty* material = actor->GetProperty();
  material->SetColor(colour.x(), colour.y(), colour.z());
  material->SetAmbient(ambient);
  material->SetDiffuse(1.0 - ambient);
  material->SetSpecular(specular);
  material->SetSpecularPower(30.0);
}

// Draws the original once more, dotted, over everything.
void make_ghost(vtkActor* ghost, vtkActor* original, double share = kGhostShare) {
  // A mapper of its own, because a mapper has one shader.
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputDataObject(original->GetMapper()->GetInputDataObject(0, 0));
  mapper->ScalarVisibilityOff();
  ghost->SetMapper(mapper);
  ghost->SetProperty(original->GetProperty());
  show_through(ghost, share);
}

// A ring round the shaft for each newton.
vtkSmartPointer<vtkPolyData> make_rings(const ProbeSizes& sizes, int newtons) {
  const double s = sizes.arrow_radius_m;
  std::vector<std::pair<double, double>> profile = {{0.0, 0.0}};
  for (int i = 1; i <= newtons; ++i) {
    const double z = i * sizes.arrow_m_per_n;
    profile.insert(profile.end(), {{0.0, z - 0.3 * s}, {1.7 * s, z - 0.3 * s}, {1.7 * s, z + 0.3 * s}, {0.0, z + 0.3 * s}});
  }
  return make_lathe(profile);
}

// Unit quaternion that turns the z axis into the direction.
Quat turn_z_to(const Vec3& direction) { return Quat::FromTwoVectors(Vec3::UnitZ(), direction); }

void place(vtkActor* actor, const Vec3& origin, const Quat& turn, const Vec3& scale) {
  Mat4 m = Mat4::Identity();
  m.topLeftCorner<3, 3>() = turn.toRotationMatrix() * scale.asDiagonal();
  m.topRightCorner<3, 1>() = origin;
  vtkNew<vtkMatrix4x4> matrix;
  copy_matrix(m, matrix);
  actor->SetUserMatrix(matrix);
}

}  // namespace

ProbeFigure::ProbeFigure(const ProbeSizes& sizes, const ProbeColours& colours) : sizes_(sizes), tip_radius_m_(sizes.tip_radius_m) {
  const double length = sizes.stylus_length_m;
  const double radius = 0.038 * length;
  const auto pen = make_lathe({{0.0, 0.0},
                               {0.16 * radius, 0.005 * length},
                               {0.30 * radius, 0.08 * length},
                               {0.86 * radius, 0.17 * length},
                               {0.86 * radius, 0.45 * length},
                               {radius, 0.46 * length},
                               {0.9 * radius, 0.95 * length},
                               {0.6 * radius, length},
                               {0.0, length}});
  set_up_actor(stylus_, pen, {0.88, 0.89, 0.91}, 0.25, 0.45);
  const auto sleeve = make_lathe({{0.86 * radius, 0.19 * length},
                                  {1.04 * radius, 0.20 * length},
                                  {1.04 * radius, 0.26 * length},
                                  {0.98 * radius, 0.27 * length},
                                  {0.98 * radius, 0.28 * length},
                                  {1.06 * radius, 0.29 * length},
                                  {1.06 * radius, 0.42 * length},
                                  {0.86 * radius, 0.43 * length}});
  set_up_actor(grip_, sleeve, colours.grip, 0.30, 0.25);
  set_up_actor(tip_, make_ball(sizes.tip_radius_m), colours.tip, 0.35, 0.5);
  const double s = sizes.arrow_radius_m;
  set_up_actor(arrow_shaft_, make_lathe({{0.0, 0.0}, {s, 0.0}, {s, 1.0}, {0.0, 1.0}}), colours.arrow, 0.55, 0.0);
  const double h = kHeadLengthInRadii * s;
  set_up_actor(arrow_head_, make_lathe({{0.0, -h}, {kHeadToShaftRadius * s, -h}, {0.0, 0.0}}), colours.arrow, 0.55, 0.0);
  set_up_actor(arrow_rings_, rings(0), 0.6 * colours.arrow, 0.7, 0.0);
  set_up_actor(arrow_limit_, make_lathe({{0.0, 0.0}, {kLimitToShaftRadius * s, 0.0}, {kLimitToShaftRadius * s, s}, {0.0, s}}),
               {0.95, 0.15, 0.10}, 0.7, 0.0);
  set_up_actor(device_point_, make_ball(0.6 * sizes.tip_radius_m), {0.95, 0.25, 0.20}, 0.6, 0.0);
  set_up_actor(penetration_, make_lathe({{0.0, 0.0}, {0.35 * s, 0.0}, {0.35 * s, 1.0}, {0.0, 1.0}}), {0.95, 0.25, 0.20}, 0.7, 0.0);
  // A disc that lies flat: z of the shape is up.
  set_up_actor(shadow_, make_lathe({{0.0, 0.0}, {1.0, 0.0}}), {0.045, 0.05, 0.06}, 1.0, 0.0);
  bring_to_front(device_point_, kGhostShare);
  bring_to_front(penetration_, kGhostShare);
  make_ghost(ghost_tip_, tip_, kTipShare);
  make_ghost(ghost_shaft_, arrow_shaft_);
  make_ghost(ghost_head_, arrow_head_);
  set_up_actor(tool_, make_ball(sizes.tip_radius_m), colours.grip, 0.3, 0.3);
  hide();
}

void ProbeFigure::hide() {
  for (vtkActor* actor : actors()) actor->VisibilityOff();
}

void ProbeFigure::add_to(vtkRenderer* renderer) {
  for (vtkActor* actor : actors()) renderer->AddActor(actor);
}

void ProbeFigure::set_tip_radius(double radius_m) {
  tip_radius_m_ = radius_m > 0.0 && std::isfinite(radius_m) ? radius_m : sizes_.tip_radius_m;
}

void ProbeFigure::set_tool(const SceneTool& tool, bool with_stylus) {
  set_up_actor(tool_, make_poly_data(*tool.mesh), Vec3(tool.colour.data()), 0.3, 0.3);
  tool_->GetProperty()->SetInterpolationToFlat();
  has_tool_ = true;
  has_stylus_ = with_stylus;
  sizes_.tool_radius_m = 0.0;
  for (const Vec3& vertex : tool.mesh->vertices) sizes_.tool_radius_m = std::max(sizes_.tool_radius_m, vertex.norm());
}

void ProbeFigure::clear_tool() {
  has_tool_ = false;
  has_stylus_ = true;
  sizes_.tool_radius_m = 0.0;
}

void ProbeFigure::set(const ProbeShown& probe) {
  place(stylus_, probe.p_WP, probe.q_WT, Vec3::Ones());
  place(grip_, probe.p_WP, probe.q_WT, Vec3::Ones());
  const Vec3 ball = Vec3::Constant(tip_radius_m_ / sizes_.tip_radius_m);
  for (vtkActor* actor : {tip_.Get(), ghost_tip_.Get()}) place(actor, probe.p_WP, Quat::Identity(), ball);
  place(tool_, probe.p_WP, probe.q_WP, Vec3::Ones());
  tool_->SetVisibility(has_tool_);
  for (vtkActor* actor : {stylus_.Get(), grip_.Get(), tip_.Get(), ghost_tip_.Get()}) actor->SetVisibility(has_stylus_);
  place_arrow(probe);
  place_device_point(probe);
  place_shadow(probe);
}

void ProbeFigure::place_shadow(const ProbeShown& probe) {
  const auto p_WS = find_shadow(probe.p_WP);
  shadow_->SetVisibility(throws_shadow_ && p_WS.has_value());
  if (!throws_shadow_ || !p_WS) return;
  // The probe's shadow is above the scene's own shadow, by about as much as that is above the ground.
  const double above = 0.5 * sizes_.tip_radius_m;
  place(shadow_, *p_WS + above * Vec3::UnitY(), turn_z_to(Vec3::UnitY()),
        {kShadowInRadii * tip_radius_m_, kShadowInRadii * tip_radius_m_, 1.0});
}

void ProbeFigure::place_arrow(const ProbeShown& probe) {
  const Vec3 arrow = compute_arrow(probe, sizes_);
  const double length = arrow.norm();
  const bool shown = length > sizes_.arrow_radius_m;
  for (vtkActor* actor : {arrow_shaft_.Get(), arrow_head_.Get(), arrow_rings_.Get(), ghost_shaft_.Get(), ghost_head_.Get()})
    actor->SetVisibility(shown);
  arrow_limit_->SetVisibility(shown && probe.force_n.norm() * sizes_.arrow_m_per_n > sizes_.arrow_max_m);
  if (!shown) return;
  const Quat along = turn_z_to(arrow);
  // The arrow begins beside the tip, so that it does not hide the contact.
  const Vec3 from = probe.p_WP + arrow / length * (kGapInRadii * tip_radius_m_);
  const double head = std::min(1.0, 0.6 * length / (kHeadLengthInRadii * sizes_.arrow_radius_m));
  const double shaft = length - 0.99 * head * kHeadLengthInRadii * sizes_.arrow_radius_m;
  for (vtkActor* actor : {arrow_shaft_.Get(), ghost_shaft_.Get()}) place(actor, from, along, {1.0, 1.0, shaft});
  for (vtkActor* actor : {arrow_head_.Get(), ghost_head_.Get()}) place(actor, from + arrow, along, Vec3::Constant(head));
  place(arrow_rings_, from, along, Vec3::Ones());
  place(arrow_limit_, from + arrow, along, Vec3::Ones());
  // Only rings on the shaft: rings under the head would be visible through it.
  const int newtons = std::clamp(static_cast<int>(shaft / sizes_.arrow_m_per_n), 0, kMaxRings);
  if (newtons == rings_shown_) return;
  rings_shown_ = newtons;
  vtkPolyDataMapper::SafeDownCast(arrow_rings_->GetMapper())->SetInputData(rings(newtons));
}

// Rings are made when they are first needed: to make all of them would take tens of milliseconds before the first frame.
vtkPolyData* ProbeFigure::rings(int newtons) {
  auto& shape = ring_shapes_[static_cast<std::size_t>(newtons)];
  if (shape == nullptr) shape = make_rings(sizes_, newtons);
  return shape;
}

void ProbeFigure::place_device_point(const ProbeShown& probe) {
  const Vec3 penetration = probe.p_WD - probe.p_WP;
  const double depth = penetration.norm();
  const bool shown = probe.contact && depth > 0.0;
  device_point_->SetVisibility(shown);
  penetration_->SetVisibility(shown);
  if (!shown) return;
  place(device_point_, probe.p_WD, Quat::Identity(), Vec3::Ones());
  place(penetration_, probe.p_WP, turn_z_to(penetration), {1.0, 1.0, depth});
}

}  // namespace hapton
