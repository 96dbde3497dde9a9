// Coulomb friction of the reference.
#include <algorithm>

#include "core/force/contact_material.h"
#include "core/force/reference/reference_proxy.h"

namespace hapton {

// The surface is nearer to the device by a point's radius.
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

// Coulomb friction: the part of the frictionless motion outside the cone.
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

}  // namespace hapton
