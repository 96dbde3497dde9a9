#include "core/force/proxy/proxy_state.h"

#include <algorithm>

namespace hapton {

ProxySurfaces::ProxySurfaces(const TouchGeometry& geometry, const std::vector<Material>& materials)
    : geometry_(geometry), materials_(materials) {
  for (const Material& material : materials) has_one_sided_ |= !material.two_sided;
  note_friction();
}

void ProxySurfaces::note_friction() noexcept {
  has_friction_ = std::ranges::any_of(materials_, [](const Material& material) { return material.friction_static > 0.0; });
}

bool ProxySurfaces::can_touch(std::uint32_t triangle, const Vec3& p) const noexcept {
  if (!has_one_sided_ || material_of(triangle).two_sided) return true;
  const Vec3& a = geometry_.corner(triangle, 0);
  return accurate_cross(geometry_.corner(triangle, 1) - a, geometry_.corner(triangle, 2) - a).dot(p - a) > 0.0;
}

Material ProxySurfaces::mean_material(const ProxyState& state) const noexcept {
  const auto active = state.active();
  if (active.size() < 2) return state.contact_count > 0 ? material_of(state.contacts[0].triangle) : materials_[0];
  ContactMaterial material;
  for (std::size_t i = 0; i < active.size(); ++i) material.add(material_of(active[i].triangle), state.multipliers[i]);
  return material.mean();
}

}  // namespace hapton
