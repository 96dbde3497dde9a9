// Follows a probe with a radius over its offset surface, from event to event.
#include <algorithm>

#include "core/force/proxy/proxy_method.h"

namespace hapton {

// True if that finished the step. Otherwise the proxy is where it stopped, with the device at `time`.
bool ProxyMethod::follow_offset(const Vec3& last, const Vec3& device, double& time) noexcept {
  if (free_) {
    if (is_point_) clear_start();
    sphere_->start_free(proxy_);
  } else if (!sphere_->is_tracking() && !sphere_->start(proxy_, false, clearance_.slop, sliding_)) {
    return false;
  }
  const std::uint64_t slips = sphere_->slips();
  const SphereFollower::Outcome outcome = sphere_->follow(last, device, time);
  counters_.slips += sphere_->slips() - slips;
  if (outcome == SphereFollower::Outcome::failed) {
    copy_sphere_state(time < 1.0 ? Vec3(last + time * (device - last)) : device);
    sphere_->stop_tracking();
    active_offset_ = contact_offset_;
    if (is_point_) clear_start();
    return false;
  }
  if (outcome == SphereFollower::Outcome::exhausted) ++counters_.exhausted;
  copy_sphere_state(device);
  return true;
}

void ProxyMethod::copy_sphere_state(const Vec3& device) noexcept {
  settle_at(sphere_->centre());
  if (is_point_) active_offset_ = sphere_->offset();
  free_ = sphere_->is_free() && proxy_ == device;
  sliding_ = sphere_->slides();
  for (const OffsetContact& active : sphere_->contacts()) {
    const OffsetContact::Proximity proximity = active.proximity(proxy_);
    Contact& contact = contacts_[contact_count_++];
    contact.triangle = active.triangle;
    contact.slot = TriangleCache::kNoSlot;
    contact.shape = active.shape;
    const bool is_face = active.part == OffsetContact::Part::face;
    contact.separation = {proximity.distance, proximity.normal, proxy_ - proximity.distance * proximity.normal,
                          is_face                                    ? Feature::face
                          : active.part == OffsetContact::Part::edge ? Feature::edge
                                                                     : Feature::vertex};
    multipliers_[active_count_++] = active.multiplier;
  }
}

}  // namespace hapton
