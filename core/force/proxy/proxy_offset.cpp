// A probe with a radius: over the offset surface from event to event.
#include <algorithm>

#include "core/force/proxy/proxy_method.h"

namespace hapton {

// True when that led to the end of the step. Else the proxy is where it came, with the device at `time`.
bool ProxyMethod::follow_offset(const Vec3& last, const Vec3& device, double& time) noexcept {
  if (free_) {
    if (is_point_) clear_start();
    sphere_->take_free(proxy_);
  } else if (!sphere_->holds() && !sphere_->take(proxy_, false, clearance_.slack, sliding_)) {
    return false;
  }
  const std::uint64_t slips = sphere_->slips();
  const SphereFollower::Outcome outcome = sphere_->follow(last, device, time);
  counters_.slips += sphere_->slips() - slips;
  if (outcome == SphereFollower::Outcome::unclear) {
    stand_at_sphere(time < 1.0 ? Vec3(last + time * (device - last)) : device);
    sphere_->leave();
    off_ = hover_;
    if (is_point_) clear_start();
    return false;
  }
  if (outcome == SphereFollower::Outcome::exhausted) ++counters_.exhausted;
  stand_at_sphere(device);
  return true;
}

void ProxyMethod::stand_at_sphere(const Vec3& device) noexcept {
  settle_at(sphere_->centre());
  if (is_point_) off_ = sphere_->offset();
  free_ = sphere_->is_free() && proxy_ == device;
  sliding_ = sphere_->slides();
  for (const OffsetContact& contact : sphere_->contacts()) {
    const OffsetContact::Stand stand = contact.stand(proxy_);
    Touch& touch = touching_[touching_count_++];
    touch.triangle = contact.triangle;
    touch.place = Neighbourhood::kNowhere;
    touch.shape = contact.shape;
    const bool is_face = contact.part == OffsetContact::Part::face;
    touch.separation = {stand.distance, stand.normal, proxy_ - stand.distance * stand.normal,
                        is_face                                     ? Feature::face
                        : contact.part == OffsetContact::Part::edge ? Feature::edge
                                                                    : Feature::vertex};
    push_[pushing_count_++] = contact.multiplier;
  }
}

}  // namespace hapton
