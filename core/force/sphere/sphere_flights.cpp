// A centre without contact goes straight to the device, until it hits something.
#include <algorithm>

#include "core/collision/swept_sphere.h"
#include "core/force/sphere/sphere_follower.h"
#include "core/math/straight_motion.h"

namespace hapton {

// Straight to the device, and on with it.
SphereFollower::Next SphereFollower::fly(const Vec3& from, const Vec3& to, double& time) noexcept {
  ++flights_;
  const Vec3 device = on_path(from, to, time);
  double until = 1.0;
  if (centre_ != device) {
    const Next next = fly_to(device, until);
    if (next != Next::settled || time >= 1.0) return next;
    return Next::again;
  }
  const Next next = fly_to(to, until);
  if (next != Next::settled) time = std::min(1.0, time + until * (1.0 - time));
  return next;
}

// settled: arrived. again: a triangle was hit on the way. failed, too, where there are many near it: a sweep can be interrupted.
SphereFollower::Next SphereFollower::fly_to(const Vec3& to, double& until) noexcept {
  constexpr int kFanInUnit = 4;  // triangles that are neighbours in memory
  const Vec3 from = centre_;
  const Vec3 motion = to - from;
  std::uint32_t first = 0;
  double time = kNever;
  int tests = 0;
  int in_fan = 0;
  near_.geometry().visit_along(from, to, clearance().offset + clearance().tolerance, [&](std::uint32_t id, double before) {
    const bool is_in_fan = near_.geometry().is_in_large_fan(id);
    if (is_in_fan ? ++in_fan > NearTriangles::kMaxVisitedInFans : ++tests > kMaxInFlight) return -1.0;
    work_ += is_in_fan ? in_fan % kFanInUnit == 0 : 1;
    const double t = time_to_block(TriangleView{near_.geometry(), id}, from, motion, std::min(before, time), clearance());
    if (!(t < time) || t > 1.0) return before;
    const ObjectGeometry::Corners corners = near_.geometry().corners(id);
    if (!near_.material(id).two_sided && !near_.can_touch(id, ContactTriangle(corners.a, corners.b, corners.c), from)) return before;
    first = id;
    time = t;
    return std::min(before, t);
  });
  has_given_up_flight_ = tests > kMaxInFlight || in_fan > NearTriangles::kMaxVisitedInFans;
  if (has_given_up_flight_) return Next::failed;
  if (time > 1.0) {
    centre_ = to;
    friction_ = {};
    return Next::settled;
  }
  centre_ = from + time * motion;
  until = time;
  ++idle_;
  if (time * motion.norm() > LocalMinimum::kMinMotion) idle_ = 0;
  least_distance_ = std::numeric_limits<double>::infinity();
  const ObjectGeometry::Corners corners = near_.geometry().corners(first);
  const ContactTriangle shape(corners.a, corners.b, corners.c);
  if (overlaps(shape)) return Next::failed;
  hint_ = motion;
  is_descending_ = true;
  return contacts_.add(OffsetContact::nearest(first, shape, centre_)) ? Next::again : Next::failed;
}

}  // namespace hapton
