// Where a point that a small sphere stands for leaves a rest that only the sphere's radius makes one: from a corner along its edges and
// faces, and over a barrier lower than the sphere.
#include <algorithm>
#include <cmath>

#include "core/force/contact_qp.h"
#include "core/force/sphere/sphere_follower.h"

namespace hapton {
namespace {

constexpr double kAround = 32.0;      // offsets: a vertex as near is the point's own
constexpr double kLeastBetter = 8.0;  // offsets: nearer by less is no way out
constexpr std::size_t kMostPlanes = 6;
constexpr double kFlat = 0x1p-20;           // slopes below this are level
constexpr double kHeights[] = {8.0, 32.0};  // offsets: of a lift

}  // namespace

// All edges and faces that begin here. A point that can get any nearer to the device can do so along one of them.
void SphereFollower::find_corner_ways() noexcept {
  if ((centre_ - corner_ways_from_).norm() <= 4.0 * keep_.offset) return;
  corner_ways_from_ = centre_;
  corner_way_count_ = 0;
  const double near = kAround * keep_.offset;
  if (!near_.covers(centre_, near) && (!gather(Vec3::Zero()) || !near_.covers(centre_, near))) return;
  const auto add = [&](const CornerWay& way) {
    for (int i = 0; i < corner_way_count_; ++i) {
      const CornerWay& known = corner_ways_[i];
      if (known.corner == way.corner && known.direction == way.direction && known.normal == way.normal) return;
    }
    if (corner_way_count_ < kMostCornerWays) corner_ways_[corner_way_count_++] = way;
  };
  std::array<const ContactTriangle*, kMostPlanes> planes{};
  std::size_t plane_count = 0;
  const auto add_line = [&](const Vec3& direction, bool ahead, bool behind) {
    CornerWay way;
    way.corner = centre_;
    way.direction = direction;
    if (ahead) add(way);
    way.direction = -direction;
    if (behind) add(way);
  };
  near_.visit_near(centre_, centre_, near, [&](int slot) {
    const ContactTriangle& shape = near_.shape(slot);
    if (!(shape.separation(centre_).distance <= near)) return;
    CornerWay face;
    face.corner = centre_;
    face.normal = shape.normal();
    int borders = 0;
    for (int k = 0; k < 3; ++k) {
      if (!(shape.length(k) > 0.0)) continue;
      const double along = shape.along(k, centre_) * shape.length(k);
      const Vec3 direction = shape.edge(k) / shape.length(k);
      const Vec3 on_edge = shape.corner(k) + std::clamp(along, 0.0, shape.length(k)) * direction;
      if ((on_edge - centre_).norm() > near) continue;
      add_line(direction, shape.length(k) - along > near, along > near);
      if (borders < 3 && !face.normal.isZero(0.0)) face.inward[static_cast<std::size_t>(borders++)] = face.normal.cross(direction);
    }
    if (face.normal.isZero(0.0)) return;
    add(face);
    for (std::size_t i = 0; i < plane_count; ++i) {
      if (std::fabs(planes[i]->normal().dot(face.normal)) > 1.0 - kFlat) return;
    }
    if (plane_count < kMostPlanes) planes[plane_count++] = &shape;
  });
  // Where faces meet that share no edge.
  const auto share_edge = [](const ContactTriangle& a, const ContactTriangle& b) {
    int shared = 0;
    for (int i = 0; i < 9; ++i) shared += a.corner(i / 3) == b.corner(i % 3);
    return shared >= 2;
  };
  for (std::size_t i = 0; i < plane_count; ++i) {
    for (std::size_t j = i + 1; j < plane_count; ++j) {
      if (share_edge(*planes[i], *planes[j])) continue;
      add_line(planes[i]->normal().cross(planes[j]->normal()).normalized(), true, true);
    }
  }
}

// Where the way leads with the device there: to the projection onto the edge or face; zero where that lies beyond its ends.
Vec3 SphereFollower::find_corner_way(const CornerWay& way, const Vec3& device) const noexcept {
  const Vec3 pull = device - way.corner;
  if (way.normal.isZero(0.0)) return std::max(0.0, way.direction.dot(pull)) * way.direction;
  const Vec3 along = pull - way.normal.dot(pull) * way.normal;
  for (const Vec3& inward : way.inward) {
    if (inward.dot(along) < 0.0) return Vec3::Zero();
  }
  return along;
}

double SphereFollower::least_corner_way(const Vec3& device) const noexcept {
  return kFlat * (device - centre_).norm() + kLeastBetter * keep_.offset;
}

// When the first of the corner's edges leads nearer to the device, in time: 2 if none does.
double SphereFollower::time_to_corner_way(const Vec3& from, const Vec3& to, double time) noexcept {
  if (!is_point_) return 2.0;
  find_corner_ways();
  const double least = 1.0625 * std::max(least_corner_way(from), least_corner_way(to));
  double soonest = 2.0;
  for (int i = 0; i < corner_way_count_; ++i) {
    const CornerWay& way = corner_ways_[i];
    if (way.is_closed || way.tried_in == step_ || !way.normal.isZero(0.0)) continue;
    const double there = way.direction.dot(to - way.corner) - least;
    if (!(there > 0.0)) continue;
    const double here = std::min(way.direction.dot(from - way.corner) - least, 0.0);
    soonest = std::min(soonest, std::max(time, here / (here - there)));
  }
  return soonest;
}

// Off the rest by the steepest way that leads to a nearer one. False, and nothing changed, where none does.
bool SphereFollower::leave_rest(const Vec3& device, const Vec3& motion) noexcept {
  if (!is_point_ || touching_ == 0) return false;
  Vec3 over;
  if (tried_shallow_in_ != step_ && is_shallow(device, over)) {
    tried_shallow_in_ = step_;
    bool is_closed = false;
    for (const double height : kHeights) {
      if (leave_along(device, motion, 32.0 * height * keep_.offset * over, height * keep_.offset, is_closed)) return true;
    }
  }
  find_corner_ways();
  const double least = least_corner_way(device);
  for (int tries = 0; tries < kMostWays; ++tries) {
    CornerWay* best = nullptr;
    Vec3 steepest = Vec3::Zero();
    for (int i = 0; i < corner_way_count_; ++i) {
      CornerWay& way = corner_ways_[i];
      if (way.is_closed || way.tried_in == step_) continue;
      const Vec3 leads = find_corner_way(way, device);
      if (leads.norm() <= std::max(least, steepest.norm())) continue;
      best = &way;
      steepest = leads;
    }
    if (best == nullptr) return false;
    best->tried_in = step_;
    for (const double height : kHeights) {
      if (leave_along(device, motion, steepest, height * keep_.offset, best->is_closed)) return true;
    }
  }
  return false;
}

// Lifted over all that is near and sent along, it goes on from there with the device held. False, and it is put back, where that ends no
// nearer.
bool SphereFollower::leave_along(const Vec3& device, const Vec3& motion, const Vec3& way, double height, bool& is_closed) noexcept {
  constexpr int kMostEvents = 256;
  if (exit_work_ > kMostExitWork) return false;
  const int work_before = work_;
  const Vec3 centre = centre_;
  const auto contacts = contacts_;
  const int count = count_;
  const int touching = touching_;
  const double distance = (device - centre_).norm();
  const auto note_work = [&] {
    exit_work_ += work_ - work_before;
    work_ = work_before;
  };
  const auto put_back = [&] {
    note_work();
    centre_ = centre;
    contacts_ = contacts;
    count_ = count;
    touching_ = touching;
    is_descending_ = false;
    has_lost_minimum_ = false;
    idle_ = 0;
    least_distance_ = std::numeric_limits<double>::infinity();
    return false;
  };
  const Vec3 up = find_lift(height);
  count_ = 0;
  touching_ = 0;
  idle_ = 0;
  is_closed = true;
  if (up.isZero(0.0) || !go_straight(up, 1.0)) return put_back();
  const double length = way.norm();
  // As far as it takes to come nearer in spite of the lift.
  const double share = std::min(1.0, std::max(8.0, 4.0 * distance / length) * height / length);
  go_straight(share * way, 0.0);
  if ((centre_ - centre).norm() < 4.0 * height) return put_back();
  is_closed = false;
  hint_ = way;
  is_descending_ = true;
  least_distance_ = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kMostEvents && idle_ <= kMostIdle; ++i) {
    ++work_;
    double until = 1.0;
    if (touching_ != 0 && !is_descending_) break;
    const Next next = touching_ == 0 ? fly_to(device, until) : descend(device, motion);
    if (next == Next::settled) break;
    if (next != Next::again) return put_back();
  }
  const bool is_done = touching_ == 0 ? centre_ == device : !is_descending_;
  if (!is_done || !((device - centre_).norm() < distance - kLeastBetter * keep_.offset)) return put_back();
  note_work();
  idle_ = 0;
  return true;
}

// The least motion that is `height` over all that is near.
Vec3 SphereFollower::find_lift(double height) noexcept {
  constexpr int kMostNear = 48;
  std::array<ContactPlane, kMostNear> planes;
  int count = 0;
  const double near = 2.0 * height;
  if (!near_.covers(centre_, near) && (!gather(Vec3::Zero()) || !near_.covers(centre_, near))) return Vec3::Zero();
  near_.visit_near(centre_, centre_, near, [&](int slot) {
    const ContactTriangle& shape = near_.shape(slot);
    const Separation at = shape.separation(centre_);
    if (count == kMostNear || at.distance > near || !can_touch(near_.triangle(slot), shape, centre_)) return;
    planes[static_cast<std::size_t>(count++)] = {at.normal, height - at.distance};
  });
  work_ += count;
  const ConstrainedMotion up =
      constrain_motion(Vec3::Zero(), std::span<const ContactPlane>(planes.data(), static_cast<std::size_t>(count)));
  return up.solved && up.motion.norm() <= 64.0 * height ? up.motion : Vec3(Vec3::Zero());
}

// Through the air, until something is in the way. False where it gets no farther than the share.
bool SphereFollower::go_straight(const Vec3& motion, double share) noexcept {
  const CentrePath path = CentrePath::straight(centre_, centre_ + motion);
  Event event;
  if (!find_event(path, event)) return false;
  centre_ = path.at(event.time);
  return event.time >= share;
}

}  // namespace hapton
