// Follows a probe with a radius over its offset surface, from event to event.
#include <algorithm>

#include "core/force/proxy/proxy_method.h"

namespace hapton {

// True if this finished the step. Otherwise the proxy is where the sphere follower stopped, for the device position at `time`.
bool ProxyMethod::follow_offset(const Vec3& last, const Vec3& device, double& time) noexcept {
  if (proxy_.is_free) {
    if (is_point_) move_start_off_surfaces();
    sphere_.start_free(proxy_.position);
  } else if (!sphere_.is_tracking()) {
    const bool has_started = sphere_.start(proxy_.position, false, clearance_.slop, proxy_.slides);
    work_left_ -= sphere_.work();
    tries_.failures += has_started ? 0 : 1;
    if (!has_started) return false;
  }
  const SphereFollower::Outcome outcome = sphere_.follow(last, device, time, work_left_);
  work_left_ -= sphere_.work();
  if (outcome == SphereFollower::Outcome::failed) {
    tries_.is_left_to_sweeps |= sphere_.has_given_up_flight();
    tries_.failures += sphere_.is_in_slit() ? 0 : 1;
    copy_sphere_state(on_path(last, device, time));
    if (!sphere_.is_in_slit()) sphere_.stop_tracking();
    active_offset_ = kContactOffset;
    if (is_point_) move_start_off_surfaces();
    return false;
  }
  if (outcome == SphereFollower::Outcome::exhausted) carry(on_path(last, device, time));
  copy_sphere_state(device);
  return true;
}

void ProxyMethod::copy_sphere_state(const Vec3& device) noexcept {
  proxy_.settle_at(sphere_.centre());
  is_at_sphere_offset_ = false;
  active_offset_ = is_point_ ? sphere_.offset() : kContactOffset;
  proxy_.is_free = sphere_.is_free() && proxy_.position == device;
  proxy_.slides = sphere_.slides();
  for (const OffsetContact& active : sphere_.contacts()) {
    const OffsetContact::Proximity at = active.proximity(proxy_.position);
    ProxyContact& contact = proxy_.contacts[proxy_.contact_count++];
    contact.triangle = active.triangle;
    contact.shape = active.shape;
    contact.separation = {at.distance, at.normal, proxy_.position - at.distance * at.normal, active.part};
    proxy_.multipliers[proxy_.active_count++] = active.multiplier;
  }
}

}  // namespace hapton
