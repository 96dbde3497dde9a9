#include "vision_node/probe_figure.h"

#include <algorithm>

#include <vtkMapper.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkShaderProperty.h>

#include "vision_node/vtk_shapes.h"

namespace hapton {
namespace {

constexpr double kHeadToShaftRadius = 2.6;
constexpr double kHeadLengthInRadii = 7.0;

void dress(vtkActor* actor, vtkPolyData* shape, const Vec3& colour, double ambient, double specular) {
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(shape);
  mapper->ScalarVisibilityOff();
  actor->SetMapper(mapper);
  vtkProperty* look = actor->GetProperty();
  look->SetColor(colour.x(), colour.y(), colour.z());
  look->SetAmbient(ambient);
  look->SetDiffuse(1.0 - ambient);
  look->SetSpecular(specular);
  look->SetSpecularPower(30.0);
}

// Moves what is drawn to the front thousandth of the depth range, its own order kept, and leaves out every other 2 x 2 block of pixels:
// blocks, because patterns of single pixels are what some stereo modes tell the eyes apart by.
void make_ghost(vtkActor* ghost, vtkActor* original) {
  // A mapper of its own: one mapper keeps one shader.
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputDataObject(original->GetMapper()->GetInputDataObject(0, 0));
  mapper->ScalarVisibilityOff();
  ghost->SetMapper(mapper);
  ghost->SetProperty(original->GetProperty());
  vtkShaderProperty* shaders = ghost->GetShaderProperty();
  shaders->AddVertexShaderReplacement("//VTK::PositionVC::Impl", true,
                                      "//VTK::PositionVC::Impl\n"
                                      "  gl_Position.z = 0.001 * gl_Position.z - 0.999 * gl_Position.w;\n",
                                      false);
  shaders->AddFragmentShaderReplacement("//VTK::Light::Impl", true,
                                        "//VTK::Light::Impl\n"
                                        "  if (((int(gl_FragCoord.x) / 2 + int(gl_FragCoord.y) / 2) & 1) == 1) discard;\n",
                                        false);
}

// Unit quaternion that turns the z axis to the direction.
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

ProbeFigure::ProbeFigure(const ProbeSizes& sizes) : sizes_(sizes) {
  const double l = sizes.stylus_length_m;
  const double r = 0.038 * l;
  const auto pen = make_lathe({{0.0, 0.0},
                               {0.16 * r, 0.005 * l},
                               {0.30 * r, 0.08 * l},
                               {0.86 * r, 0.17 * l},
                               {0.86 * r, 0.45 * l},
                               {r, 0.46 * l},
                               {0.9 * r, 0.95 * l},
                               {0.6 * r, l},
                               {0.0, l}});
  dress(stylus_, pen, {0.88, 0.89, 0.91}, 0.25, 0.45);
  const auto sleeve = make_lathe({{0.86 * r, 0.19 * l},
                                  {1.04 * r, 0.20 * l},
                                  {1.04 * r, 0.26 * l},
                                  {0.98 * r, 0.27 * l},
                                  {0.98 * r, 0.28 * l},
                                  {1.06 * r, 0.29 * l},
                                  {1.06 * r, 0.42 * l},
                                  {0.86 * r, 0.43 * l}});
  dress(grip_, sleeve, {0.16, 0.17, 0.20}, 0.30, 0.25);
  dress(tip_, make_ball(sizes.tip_radius_m), {1.0, 0.78, 0.10}, 0.35, 0.5);
  const double s = sizes.arrow_radius_m;
  dress(shaft_, make_lathe({{0.0, 0.0}, {s, 0.0}, {s, 1.0}, {0.0, 1.0}}), {0.20, 0.90, 0.45}, 0.55, 0.0);
  const double h = kHeadLengthInRadii * s;
  dress(head_, make_lathe({{0.0, -h}, {kHeadToShaftRadius * s, -h}, {0.0, 0.0}}), {0.20, 0.90, 0.45}, 0.55, 0.0);
  make_ghost(ghost_shaft_, shaft_);
  make_ghost(ghost_head_, head_);
  for (vtkActor* actor : actors()) actor->VisibilityOff();
}

void ProbeFigure::add_to(vtkRenderer* renderer) {
  for (vtkActor* actor : actors()) renderer->AddActor(actor);
}

void ProbeFigure::set(const ProbeShown& probe) {
  place(stylus_, probe.p_WP, probe.q_WT, Vec3::Ones());
  place(grip_, probe.p_WP, probe.q_WT, Vec3::Ones());
  place(tip_, probe.p_WP, Quat::Identity(), Vec3::Ones());
  stylus_->VisibilityOn();
  grip_->VisibilityOn();
  tip_->VisibilityOn();
  const Vec3 arrow = compute_arrow(probe, sizes_);
  const double length = arrow.norm();
  const bool shown = length > sizes_.arrow_radius_m;
  for (vtkActor* actor : {shaft_.Get(), head_.Get(), ghost_shaft_.Get(), ghost_head_.Get()}) actor->SetVisibility(shown);
  if (!shown) return;
  const Quat along = turn_z_to(arrow);
  const double head = std::min(1.0, 0.6 * length / (kHeadLengthInRadii * sizes_.arrow_radius_m));
  const double shaft = length - 0.99 * head * kHeadLengthInRadii * sizes_.arrow_radius_m;
  for (vtkActor* actor : {shaft_.Get(), ghost_shaft_.Get()}) place(actor, probe.p_WP, along, {1.0, 1.0, shaft});
  for (vtkActor* actor : {head_.Get(), ghost_head_.Get()}) place(actor, probe.p_WP + arrow, along, Vec3::Constant(head));
}

}  // namespace hapton
