// The quick way: where the surface is plain the facets alone tell where the proxy comes to rest.
#include <algorithm>

#include "core/force/proxy/facet_descent.h"
#include "core/force/proxy/proxy_method.h"

namespace hapton {
// Moves a proxy that a face or fold holds to its minimum, as descend() would. False, and nothing moved, where that is not plain, or where
// the proxy leaps: then it does not cling to the surface.
bool ProxyMethod::walk(const Vec3& device) noexcept {
  if (!is_point_ || free_ || pushing_count_ < 1 || pushing_count_ > (has_friction_ ? 1 : 2)) return false;
  Vec3 along = device - proxy_;
  if (!(along.norm() <= kLongestMotion)) return false;  // a device far away costs digits
  std::array<FacetDescent::Hold, 2> held;
  for (int i = 0; i < pushing_count_; ++i) {
    if (touching_[i].separation.feature != Feature::face) return false;
    held[i].normal = touching_[i].separation.normal;
    along -= held[i].normal.dot(along) * held[i].normal;
  }
  double length = along.norm();
  if (length > kLeap * stride_) {  // it will not go as far
    along *= kLeap * stride_ / length;
    length = kLeap * stride_;
  }
  if (!stay_near(proxy_, along, kAround * length + kBeside * hover_, kAhead)) return false;
  for (int i = 0; i < pushing_count_; ++i) held[i].place = near().place_of(touching_[i].triangle, touching_[i].place);
  FacetDescent way = facets();
  if (!way.run(proxy_, std::span(held).first(static_cast<std::size_t>(pushing_count_)), device) || !is_open_to(way)) return false;
  if ((way.end() - proxy_).norm() > kLeap * stride_ + kBeside * hover_) return false;
  ++counters_.walks;
  const Vec3 from = proxy_;
  met_fold_ |= way.met_fold();
  sliding_ = has_friction_ && way.slides();
  proxy_ = way.end();
  touching_count_ = 0;
  for (const FacetDescent::Hold& hold : way.holds()) {
    push_[touching_count_] = hold.push;
    Touch& touch = touching_[touching_count_++];
    touch.triangle = near().triangle_at(hold.place);
    touch.place = hold.place;
    touch.shape = near().shape(hold.place);
    touch.separation = {clearance_.rest, hold.normal, proxy_ - clearance_.rest * hold.normal, Feature::face};
  }
  pushing_count_ = touching_count_;
  look_ahead(proxy_ - from);
  return true;
}

FacetDescent ProxyMethod::facets() noexcept {
  const double margin = kBeside * hover_;
  if (!has_friction_) return {near(), clearance_.rest, margin};
  const Material material = touched_material();
  return {near(), clearance_.rest, margin, {material.friction_static, material.friction_dynamic, sliding_}};
}

// One-sided faces hold only from their front.
bool ProxyMethod::is_open_to(const FacetDescent& way) const noexcept {
  if (!has_one_sided_) return true;
  const auto faces = way.faces();
  return std::all_of(faces.begin(), faces.end(), [&](std::uint32_t place) { return can_touch(near().triangle_at(place), proxy_); });
}

}  // namespace hapton
