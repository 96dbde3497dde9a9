// Coulomb friction of the reference.
#include <algorithm>

#include "core/force/contact_material.h"
#include "core/force/reference/reference_proxy.h"

namespace hapton {

// The surface itself is a point's radius nearer to the device.
double ReferenceProxy::pressure_of(double push) const noexcept { return rest_ == kPointRadius ? std::max(0.0, push - rest_) : push; }

Material ReferenceProxy::material_of(const Pull& pull) const noexcept {
  ContactMaterial material;
  for (int i = 0; i < pull.motion.count; ++i) {
    material.add(materials_[state_.contacts[pull.motion.active[i]].face.object], pull.motion.multiplier[i]);
  }
  return material.mean();
}

// Coulomb friction: the part of the frictionless motion that the cone leaves.
Vec3 ReferenceProxy::limit_by_friction(const Pull& pull) noexcept {
  const Vec3& motion = pull.motion.point;
  if (!has_friction() || pull.strongest == nullptr) return motion;
  Vec3 push = Vec3::Zero();
  for (int i = 0; i < pull.motion.count; ++i) push += pull.motion.multiplier[i] * state_.contacts[pull.motion.active[i]].near.direction;
  const Material material = material_of(pull);
  const double way = motion.norm();
  const double pressure = pressure_of(push.norm());
  if (!exceeds_friction(way, pressure, material)) return Vec3::Zero();
  return motion * ((way - material.friction_dynamic * pressure) / way);
}

}  // namespace hapton
