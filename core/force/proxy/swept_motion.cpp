#include "core/force/proxy/swept_motion.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/force/sliding_friction.h"

namespace hapton {
namespace {

constexpr double kLongestMotion = 4.0;         // local units: twice the scene's size
constexpr double kFarthestGoal = 0x1p10;       // local units: a device farther out would cost significant digits
constexpr double kDistanceRounding = 0x1p-48;  // local units: bound on the rounding of a distance within the scene

// Limits a motion to the length that crosses the scene.
Vec3 shortened(const Vec3& motion) {
  const double length = motion.norm();
  return length > kLongestMotion ? Vec3(motion * (kLongestMotion / length)) : motion;
}

}  // namespace

// Every motion leads nearer to the device or adds an active constraint.
bool SweptMotion::descend(ProxyState& proxy, const Vec3& device, int most_work) noexcept {
  work_ = 0;
  most_work_ = most_work;
  if (has_settled_ || device != device_) forget_progress();
  device_ = device;
  proxy.active_count = 0;  // until the proxy has settled
  has_settled_ = settle(proxy, device);
  if (is_point_ && !sweep_.is_interrupted()) present_clearance_ = clearance_;
  if (!has_settled_) ++counters_.unconverged;
  return has_settled_;
}

void SweptMotion::keep_only(double offset) noexcept {
  present_clearance_ = {.offset = offset, .slop = 0x1p-3 * offset, .tolerance = 0x1p-9 * offset};
}

void SweptMotion::forget_progress() noexcept {
  least_distance_ = std::numeric_limits<double>::infinity();
  largest_deviation_ = 0.0;
  idle_motions_ = 0;
}

bool SweptMotion::settle(ProxyState& proxy, const Vec3& device) noexcept {
  constexpr double kNormalError = 0x1p-24;  // share of the goal: error of an edge's normal at the contact offset (point_triangle.h)
  if (const auto ended = finish_interrupted(proxy, device)) return *ended;
  if (is_shrunk() && !is_point_) grow_to_room(proxy.position);
  bool has_forgotten = false;
  for (int i = 0; i < kMaxMotions && work_ <= most_work_; ++i) {
    work_ += kWorkOfMotion;
    if (proxy.contact_count == 0 && cross_empty_space(proxy, device)) return true;
    Vec3 goal = device - proxy.position;
    const double distance = goal.norm();
    const bool arrives = distance <= kLongestMotion;
    if (distance > kFarthestGoal) goal *= kFarthestGoal / distance;
    note_progress(distance);
    if (idle_motions_ > kMaxIdleMotions && proxy.contact_count > 0) {  // moving back and forth within the slop of the clearance
      if (is_too_near(proxy) && shrink_to_room(proxy.position)) {
        idle_motions_ = 0;
        continue;
      }
      proxy.active_count = 1;
      proxy.multipliers[0] = distance;
      return true;
    }
    fixed_count_ = 0;
    if (proxy.contact_count == 0) {
      const End end = advance(proxy, shortened(goal));
      if (end == End::interrupted) return false;
      if (end == End::free && arrives) {
        proxy.settle_at(device);
        return true;
      }
      continue;
    }
    ++counters_.motions;
    ConstrainedMotion constrained = next_motion(proxy, goal);
    if (proxy.contact_count == ProxyState::kMaxContacts) fix_active(proxy, constrained, goal);
    const Vec3 motion = surfaces_.has_friction() ? apply_friction(proxy, goal, constrained) : rolled(proxy, constrained, device);
    if (motion.norm() <= present_clearance_.tolerance + kNormalError * distance) {
      if (const auto ended = end_at_minimum(proxy, constrained, has_forgotten)) return *ended;
      continue;
    }
    const End end = advance(proxy, shortened(motion));
    if (end == End::interrupted) return false;
    if (end == End::free && constrained.active_count == 0 && arrives) {
      proxy.settle_at(device);
      return true;
    }
  }
  return false;
}

// Continues a motion that the last call interrupted because its work was used up, unless something else has moved the proxy since.
std::optional<bool> SweptMotion::finish_interrupted(ProxyState& proxy, const Vec3& device) noexcept {
  if (sweep_.is_interrupted() && sweep_.from() != proxy.position) sweep_.drop();
  if (!sweep_.is_interrupted()) return std::nullopt;
  if (go_on(proxy) == End::interrupted) return false;
  if (proxy.contact_count == 0 && (device - proxy.position).norm() <= kDistanceRounding) {  // arrived, and all of the way was swept
    proxy.settle_at(device);
    return true;
  }
  return std::nullopt;
}

// The next motion would be smaller than its errors, so the proxy is at a minimum, unless a sphere overlaps triangles that it has not
// looked for, or a doubtful contact holds the proxy.
std::optional<bool> SweptMotion::end_at_minimum(ProxyState& proxy, ConstrainedMotion& constrained, bool& has_forgotten) noexcept {
  if (may_overlap_more(proxy)) {
    if (advance(proxy, Vec3::Zero()) == End::interrupted) return false;
    return std::nullopt;
  }
  if (!has_forgotten && forget_doubtful(proxy, constrained)) {
    has_forgotten = true;
    return std::nullopt;
  }
  bring_active_first(proxy, constrained);
  proxy.multipliers = constrained.multipliers;
  proxy.active_count = constrained.active_count;
  return true;
}

// A sphere that has the largest number of contacts may overlap more triangles. A sweep of length zero finds those that it overlaps most.
bool SweptMotion::may_overlap_more(const ProxyState& proxy) const noexcept {
  return !is_point_ && !has_searched_overlaps_ && proxy.contact_count == ProxyState::kMaxContacts;
}

void SweptMotion::note_progress(double distance) noexcept {
  const bool is_nearer = distance < least_distance_ - kDistanceRounding;
  idle_motions_ = is_nearer ? 0 : idle_motions_ + 1;
  if (is_nearer) largest_deviation_ = 0.0;
  least_distance_ = std::min(least_distance_, distance);
}

// If there are more contacts than can be kept, those that hold the motion stay. A motion that is stopped at once makes progress as long as
// the contacts that stopped it push the motion farther from the goal.
void SweptMotion::fix_active(ProxyState& proxy, ConstrainedMotion& constrained, const Vec3& goal) noexcept {
  // Larger than the rounding of a length, which does not count as progress.
  constexpr double kFarther = 1.0 + 0x1p-40;
  bring_active_first(proxy, constrained);
  fixed_count_ = constrained.active_count;
  const double deviation = (constrained.motion - goal).norm();
  if (deviation > kFarther * largest_deviation_) idle_motions_ = 0;
  largest_deviation_ = std::max(largest_deviation_, deviation);
}

// Far outside the scene there are no contacts and positions are coarse: the proxy goes straight to the device (true), or to where its path
// enters the scene's surroundings.
bool SweptMotion::cross_empty_space(ProxyState& proxy, const Vec3& device) const noexcept {
  const double surroundings = 2.0 + 2.0 * present_clearance_.offset;
  if (proxy.position.norm() <= 1.01 * surroundings) return false;
  const Vec3 path = device - proxy.position;
  const double length = path.norm();
  const Vec3 direction = length > 0.0 ? Vec3(path / length) : Vec3::Zero();
  const double closest_at = -proxy.position.dot(direction);
  const double miss = (proxy.position + closest_at * direction).norm();
  const double entry = closest_at - std::sqrt(std::max(0.0, (surroundings - miss) * (surroundings + miss)));
  if (miss >= surroundings || entry <= 0.0 || entry >= length) {
    proxy.settle_at(device);
    return true;
  }
  proxy.position += entry * direction;
  return false;
}

// Contacts that are too near lift the proxy. Where they leave no room for that, as in a slit narrower than the probe, the probe shrinks to
// the room. The planes of walls that are parallel within rounding, with no room between them, meet far away: such a lift is no solution.
ConstrainedMotion SweptMotion::next_motion(const ProxyState& proxy, const Vec3& goal) noexcept {
  constexpr double kFarthestLift = 8.0;  // offsets
  const auto constrain = [&] {
    for (int i = 0; i < proxy.contact_count; ++i) {
      const Separation& s = proxy.contacts[i].separation;
      planes_[i] = {s.normal, present_clearance_.offset - s.distance};
    }
    return constrain_motion(goal, std::span(planes_).first(static_cast<std::size_t>(proxy.contact_count)));
  };
  const ConstrainedMotion constrained = constrain();
  const bool has_room = constrained.solved && constrained.motion.norm() <= goal.norm() + kFarthestLift * present_clearance_.offset;
  if (has_room || !is_too_near(proxy) || !shrink_to_room(proxy.position)) return constrained;
  return constrain();
}

bool SweptMotion::is_too_near(const ProxyState& proxy) const noexcept {
  return std::any_of(proxy.contacts.begin(), proxy.contacts.begin() + proxy.contact_count, [&](const ProxyContact& contact) {
    return present_clearance_.offset - contact.separation.distance > 2.0 * present_clearance_.slop;
  });
}

// The distance to the nearest surface, at most the probe's own size. Among too many triangles it may be less: then `is_certain` is false.
double SweptMotion::find_room(const Vec3& p, bool& is_certain) noexcept {
  constexpr int kMaxTests = 256;  // about half of the work of a step (StepWork::kMax)
  double room = clearance_.offset;
  int tests = 0;
  surfaces_.geometry().visit_nearest(p, room * room, [&](std::uint32_t triangle, double) {
    if (++tests > kMaxTests) return 0.0;
    if (surfaces_.can_touch(triangle, p)) room = std::min(room, surfaces_.geometry().separation(triangle, p).distance);
    return room * room;
  });
  is_certain = tests <= kMaxTests;
  work_ += std::min(tests, kMaxTests);
  return room;
}

// False: the centre is on a surface, or the proxy is already that small.
bool SweptMotion::shrink_to_room(const Vec3& p) noexcept {
  bool is_certain = false;
  const double room = find_room(p, is_certain);
  if (room <= 2.0 * present_clearance_.slop || room >= present_clearance_.offset) return false;
  present_clearance_.offset = room;
  return true;
}

// Growth never pushes the proxy: where a surface holds the proxy, there is no more room. It fills only a share of the room: in a passage of
// changing width, a sphere as large as the room would stop at each narrower place.
void SweptMotion::grow_to_room(const Vec3& p) noexcept {
  constexpr double kRoomShare = 0.5;
  bool is_certain = false;
  const double room = find_room(p, is_certain);
  if (!is_certain) return;
  present_clearance_.offset =
      room >= clearance_.offset - clearance_.slop ? clearance_.offset : std::max(present_clearance_.offset, kRoomShare * room);
}

// If the device is near the edge or vertex in contact, the pull along the surface is small all the way to the minimum, however far that is:
// each motion by that pull would leave depth / radius of the way. From any position on the line through the edge and the device, the pull
// takes the sphere straight to the minimum on the surface. So the motion goes along the tangent to that line, or part of the way.
Vec3 SweptMotion::rolled(const ProxyState& proxy, const ConstrainedMotion& constrained, const Vec3& device) const noexcept {
  constexpr double kMaxAngle = 0.25;     // rad
  constexpr double kMinAngle = 0x1p-20;  // rad; a minimum at a smaller angle is reached without this
  constexpr double kRounding = 0x1p-48;  // rounding of positions; the normal's error is this over the distance
  const Vec3& motion = constrained.motion;
  if (is_point_ || constrained.active_count != 1) return motion;
  const auto& [triangle, shape, s] = proxy.contacts[static_cast<std::size_t>(constrained.active[0])];
  if (s.feature == Feature::face) return motion;
  Vec3 turn = motion;
  if (s.feature == Feature::edge) {
    const Vec3 axis = shape.edge(shape.boundary(s.nearest).edge).normalized();
    turn -= axis.dot(turn) * axis;
  }
  const double length = turn.norm();
  if (!(length > 0.0)) return motion;
  const Vec3 out = device - s.nearest;
  const double angle = std::atan2(out.dot(turn) / length, out.dot(s.normal));
  const double error = kRounding / s.distance * (device - proxy.position).norm() / length;  // of the direction, and so of the angle
  if (!(angle > kMinAngle + error)) return motion;
  return motion + turn * (std::max(1.0, s.distance * std::tan(std::min(angle, kMaxAngle)) / length) - 1.0);
}

// Coulomb friction: the frictionless goal is `depth` above the device; the proxy may stay up to mu * depth short of the goal.
Vec3 SweptMotion::apply_friction(ProxyState& proxy, const Vec3& goal, const ConstrainedMotion& constrained) const noexcept {
  const Vec3& motion = constrained.motion;
  const Material material = material_of(proxy, constrained);
  const double depth = (goal - motion).norm();
  const double length = motion.norm();
  const double held_length = (proxy.slides ? material.friction_dynamic : material.friction_static) * depth;
  if (length <= held_length + present_clearance_.slop) {
    if (length < FrictionMotion::kRestick * material.friction_dynamic * depth) proxy.slides = false;
    return Vec3::Zero();
  }
  proxy.slides = true;
  return motion * (1.0 - material.friction_dynamic * depth / length);
}

Material SweptMotion::material_of(const ProxyState& proxy, const ConstrainedMotion& constrained) const noexcept {
  if (constrained.active_count == 0) return surfaces_.mean_material(proxy);
  ContactMaterial material;
  for (int i = 0; i < constrained.active_count; ++i)
    material.add(surfaces_.material_of(proxy.contacts[constrained.active[i]].triangle), constrained.multipliers[i]);
  return material.mean();
}

// An edge or vertex contact of a point probe may be due to rounding only. Drops such contacts, so that the next sweep shows whether they
// block. Returns false if there are none.
bool SweptMotion::forget_doubtful(ProxyState& proxy, const ConstrainedMotion& constrained) const noexcept {
  if (!is_point_) return false;
  bool any = false;
  for (int i = 0; i < constrained.active_count; ++i) any |= proxy.contacts[constrained.active[i]].separation.feature != Feature::face;
  if (!any) return false;
  const auto end = std::remove_if(proxy.contacts.begin(), proxy.contacts.begin() + proxy.contact_count,
                                  [](const ProxyContact& contact) { return contact.separation.feature != Feature::face; });
  proxy.contact_count = static_cast<int>(end - proxy.contacts.begin());
  return true;
}

void SweptMotion::bring_active_first(ProxyState& proxy, ConstrainedMotion& constrained) noexcept {
  std::array<int, 3>& at = constrained.active;
  for (int i = 0; i < constrained.active_count; ++i) {
    if (at[i] == i) continue;
    std::swap(proxy.contacts[i], proxy.contacts[at[i]]);
    for (int j = i + 1; j < constrained.active_count; ++j) {
      if (at[j] == i) at[j] = at[i];  // this contact was swapped away above
    }
    at[i] = i;
  }
}

// Moves the proxy along `motion` until something stops it. proxy.contacts then holds what the proxy touches.
SweptMotion::End SweptMotion::advance(ProxyState& proxy, const Vec3& motion) noexcept {
  ++counters_.sweeps;
  sweep_.start(proxy.position, motion);
  return go_on(proxy);
}

// If the work is used up in the middle of a sweep, the proxy stays where it is and does not count as being at the device.
SweptMotion::End SweptMotion::go_on(ProxyState& proxy) noexcept {
  const End end = sweep_.go_on(proxy, present_clearance_, fixed_count_, work_, most_work_);
  counters_.tests = sweep_.tests();
  if (end != End::free) proxy.is_free = false;
  if (end == End::interrupted) return end;
  const Vec3& motion = sweep_.motion();
  has_searched_overlaps_ = motion.isZero(0.0);
  const bool is_stopped = end == End::stopped;
  const double t = sweep_.time();
  proxy.position += (is_stopped ? t : 1.0) * motion;
  update_contacts(proxy, is_stopped ? Vec3((1.0 - t) * motion) : Vec3::Zero());
  return end;
}

// After a motion: keeps the contacts that still touch and adds the blockers. If all contacts are used, a blocker takes the place of one
// that did not hold the motion.
void SweptMotion::update_contacts(ProxyState& proxy, const Vec3& blocked_motion) const noexcept {
  const double bound = present_clearance_.offset + 2.0 * present_clearance_.tolerance;
  const auto blockers = sweep_.blockers();
  int kept_count = 0;
  int fixed_count = 0;
  for (int i = 0; i < proxy.contact_count; ++i) {
    ProxyContact& contact = proxy.contacts[i];
    if (std::any_of(blockers.begin(), blockers.end(), [&](const auto& b) { return b.triangle == contact.triangle; })) continue;
    contact.separation = contact.shape.separation(proxy.position);
    if (contact.separation.distance > bound) continue;
    if (kept_count != i) proxy.contacts[kept_count] = contact;
    ++kept_count;
    if (i < fixed_count_) fixed_count = kept_count;
  }
  int replaced = kept_count;
  for (const StraightSweep::Blocker& blocker : blockers) {
    ProxyContact contact{.triangle = blocker.triangle, .shape = surfaces_.shape_of(blocker.triangle), .separation = {}};
    contact.separation = blocking_separation(contact.shape, proxy.position, blocked_motion, present_clearance_);
    if (contact.separation.distance > bound) continue;
    if (kept_count < ProxyState::kMaxContacts) {
      proxy.contacts[kept_count++] = contact;
    } else if (replaced > fixed_count) {
      proxy.contacts[--replaced] = contact;
    }
  }
  proxy.contact_count = kept_count;
}

}  // namespace hapton
