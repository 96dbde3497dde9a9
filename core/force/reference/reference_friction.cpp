// Coulomb friction of the reference.
#include <algorithm>
#include <array>

#include "core/force/contact_material.h"
#include "core/force/reference/reference_proxy.h"
#include "core/force/sliding_friction.h"

namespace hapton {

// The proxy of a point is above the surface by its radius, so the surface is nearer to the device by that.
double ReferenceProxy::pressure_of(double depth) const noexcept {
  return rest_offset_ == kPointRadius ? std::max(0.0, depth - rest_offset_) : depth;
}

Material ReferenceProxy::material_of(const Pull& pull) const noexcept {
  ContactMaterial material;
  for (int i = 0; i < pull.motion.count; ++i) {
    material.add(materials_[state_.contacts[pull.motion.active[i]].face.object], pull.motion.multiplier[i]);
  }
  return material.mean();
}

// Whether a pull along the surface exceeds the cone, so that the proxy slides.
bool ReferenceProxy::exceeds_friction(double pull, double depth, const Material& material) noexcept {
  const double held = (state_.sliding ? material.friction_dynamic : material.friction_static) * depth;
  const bool exceeds = pull > held + kStill;
  state_.sliding = exceeds || (state_.sliding && pull >= FrictionMotion::kRestick * material.friction_dynamic * depth);
  return exceeds;
}

// Coulomb friction: keeps the part of the frictionless motion that lies outside the cone.
Vec3 ReferenceProxy::limit_by_friction(const Pull& pull) noexcept {
  const Vec3& motion = pull.motion.point;
  if (!has_friction() || pull.strongest == nullptr) return motion;
  Vec3 normal_pull = Vec3::Zero();
  for (int i = 0; i < pull.motion.count; ++i)
    normal_pull += pull.motion.multiplier[i] * state_.contacts[pull.motion.active[i]].near.direction;
  const Material material = material_of(pull);
  const double length = motion.norm();
  const double pressure = pressure_of(normal_pull.norm());
  if (!exceeds_friction(length, pressure, material)) return Vec3::Zero();
  return motion * ((length - material.friction_dynamic * pressure) / length);
}

// Friction on one plane, in closed form. Return mapping (limit_by_friction) has an error of second order in the sub-step, in each sub-step.
void ReferenceProxy::drag(const Vec3& device_from, const Vec3& device_to) noexcept {
  if (!has_friction() || device_from == device_to) return;
  update_contacts();
  const Pull before = project_pull(device_from - state_.position);
  if (before.motion.count != 1 || before.strongest->near.feature != TriangleFeature::face) return;
  Vec3 on_edge;
  std::array<EdgeFace, 2> sides;
  if (find_vertex(before) != nullptr || find_concave_edge(before, on_edge, sides)) return;
  const Vec3 normal = before.strongest->near.direction;
  const Pull after = project_pull(device_to - state_.position);
  if (after.motion.count != 1 || after.strongest->near.direction.dot(normal) < 1.0 - kSamePlane) return;
  const auto in_plane = [&](const Vec3& v) { return Vec3(v - v.dot(normal) * normal); };
  const Material material = material_of(after);
  FrictionMotion input;
  input.pull = in_plane(device_from - state_.position);
  input.motion = in_plane(device_to - device_from);
  input.pressure_start = pressure_of(before.motion.multiplier[0]);
  input.pressure_end = pressure_of(after.motion.multiplier[0]);
  input.friction_static = material.friction_static;
  input.friction_dynamic = material.friction_dynamic;
  input.sliding = state_.sliding;
  if (!(input.pressure_start > 0.0 && input.pressure_end > 0.0)) return;
  const FrictionDrag dragged = drag_by_friction(input);
  const Vec3 motion = cut_at_boundary(after, input.pull + input.motion - dragged.pull);
  state_.sliding = dragged.sliding;
  if (motion.norm() > kStill && motion.norm() <= kLongestMotion) advance(motion);
}

}  // namespace hapton
