// Fast path of the sweeps: FacetDescent finds the minimum by adjacency where the surface is locally manifold.
#include <algorithm>

#include "core/force/proxy/facet_descent.h"
#include "core/force/proxy/proxy_method.h"

namespace hapton {
// Moves a proxy held by a face or a concave edge to its minimum, as descend() would. Returns false, and moves nothing, if the surface is
// not locally manifold there or the proxy jumps: a jump leaves the surface.
bool ProxyMethod::walk(const Vec3& device) noexcept {
  if (!is_point_ || free_ || active_count_ < 1 || active_count_ > (has_friction_ ? 1 : 2)) return false;
  Vec3 along = device - proxy_;
  if (!(along.norm() <= kLongestMotion)) return false;  // a distant device costs significant digits
  std::array<FacetDescent::Constraint, 2> held;
  for (int i = 0; i < active_count_; ++i) {
    if (contacts_[i].separation.feature != Feature::face) return false;
    held[i].normal = contacts_[i].separation.normal;
    along -= held[i].normal.dot(along) * held[i].normal;
  }
  double length = along.norm();
  if (length > kJump * displacement_) {  // it cannot go farther
    along *= kJump * displacement_ / length;
    length = kJump * displacement_;
  }
  if (!keep_cached(proxy_, along, kCacheMargin * length + kBeside * contact_offset_, kCacheAhead)) return false;
  for (int i = 0; i < active_count_; ++i) held[i].slot = cache().slot_of(contacts_[i].triangle, contacts_[i].slot);
  FacetDescent descent = facets();
  if (!descent.run(proxy_, std::span(held).first(static_cast<std::size_t>(active_count_)), device) || !is_open_to(descent)) return false;
  if ((descent.end() - proxy_).norm() > kJump * displacement_ + kBeside * contact_offset_) return false;
  ++counters_.facet_descents;
  const Vec3 from = proxy_;
  met_concave_edge_ |= descent.met_concave_edge();
  sliding_ = has_friction_ && descent.slides();
  proxy_ = descent.end();
  contact_count_ = 0;
  for (const FacetDescent::Constraint& constraint : descent.constraints()) {
    multipliers_[contact_count_] = constraint.multiplier;
    Contact& contact = contacts_[contact_count_++];
    contact.triangle = cache().triangle_at(constraint.slot);
    contact.slot = constraint.slot;
    contact.shape = cache().shape(constraint.slot);
    contact.separation = {clearance_.offset, constraint.normal, proxy_ - clearance_.offset * constraint.normal, Feature::face};
  }
  active_count_ = contact_count_;
  prefetch_cache(proxy_ - from);
  return true;
}

FacetDescent ProxyMethod::facets() noexcept {
  const double margin = kBeside * contact_offset_;
  if (!has_friction_) return {cache(), clearance_.offset, margin};
  const Material material = contact_material();
  return {cache(), clearance_.offset, margin, {material.friction_static, material.friction_dynamic, sliding_}};
}

// One-sided faces hold only from the front.
bool ProxyMethod::is_open_to(const FacetDescent& descent) const noexcept {
  if (!has_one_sided_) return true;
  const auto faces = descent.faces();
  return std::all_of(faces.begin(), faces.end(), [&](std::uint32_t slot) { return can_touch(cache().triangle_at(slot), proxy_); });
}

}  // namespace hapton
