#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/collision/touch_geometry.h"
#include "core/force/contact_material.h"
#include "core/geometry/contact_triangle.h"

namespace hapton {

struct ProxyContact {
  std::uint32_t triangle = 0;
  ContactTriangle shape;
  Separation separation;  // of the proxy
};

// Position and contacts of the proxy. Frame and unit: TouchGeometry's local ones.
struct ProxyState {
  static constexpr int kMaxContacts = 32;  // far more than the three that can constrain the proxy

  Vec3 position = Vec3::Zero();
  bool is_free = true;  // no contact: the proxy is the device point
  bool slides = false;  // under friction: the dynamic coefficient applies
  std::array<ProxyContact, kMaxContacts> contacts;
  int contact_count = 0;
  std::array<double, 3> multipliers = {0, 0, 0};  // of the active constraints
  int active_count = 0;                           // the first ones of `contacts` are the active constraints

  std::span<const ProxyContact> active() const {
    return {contacts.data(), static_cast<std::size_t>(active_count < contact_count ? active_count : contact_count)};
  }
  // The triangle of the active constraint with the largest multiplier. Pre: a contact.
  std::uint32_t strongest_triangle() const noexcept {
    std::size_t strongest = 0;
    for (std::size_t i = 1; i < active().size(); ++i) {
      if (multipliers[i] > multipliers[strongest]) strongest = i;
    }
    return contacts[strongest].triangle;
  }
  void settle_at(const Vec3& p) noexcept {
    position = p;
    is_free = true;
    slides = false;
    contact_count = 0;
    active_count = 0;
  }
};

// The surfaces of a scene: from which side each can be touched, and their materials. RT: queries yes. Keeps references.
class ProxySurfaces {
 public:
  // materials: one for each object. Pre: geometry and materials outlive this object.
  ProxySurfaces(const TouchGeometry& geometry, const std::vector<Material>& materials);

  // Call when the friction of the materials has changed.
  void note_friction() noexcept;

  const TouchGeometry& geometry() const { return geometry_; }
  const std::vector<Material>& materials() const { return materials_; }  // by object
  bool has_friction() const { return has_friction_; }
  const Material& material_of(std::uint32_t triangle) const { return materials_[geometry_.mesh_of(triangle)]; }
  ContactTriangle shape_of(std::uint32_t triangle) const {
    return {geometry_.corner(triangle, 0), geometry_.corner(triangle, 1), geometry_.corner(triangle, 2)};
  }
  // A one-sided triangle is touched only from the side that its normal points to.
  bool can_touch(std::uint32_t triangle, const Vec3& p) const noexcept;
  // The mean material of all active constraints (ContactMaterial); fewer than two: that of the first contact; none: of the first object.
  Material mean_material(const ProxyState& state) const noexcept;

 private:
  const TouchGeometry& geometry_;
  const std::vector<Material>& materials_;
  bool has_one_sided_ = false;
  bool has_friction_ = false;
};

}  // namespace hapton
