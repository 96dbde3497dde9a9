// Leaves local minima that exist only because of the contact offset. It makes a point probe a small sphere, which can balance on an edge or
// stop where a concave edge narrows at a vertex, at a step no higher than its radius; a point would move on.
#include <algorithm>
#include <cmath>

#include "core/force/proxy/proxy_method.h"

namespace hapton {
namespace {

constexpr double kLeastGain = 4.0;           // contact offsets: a smaller gain is not worth a step, it cannot be felt
constexpr double kNearBoundary = 16.0;       // contact offsets: a face contact this near to the boundary may be at the edge
constexpr double kFlat = 0x1p-20;            // slopes below this are level
constexpr double kLevel = 0x1p-10;           // sine of the angle between two planes that hold a sphere: below it they count as one plane
constexpr double kHeights[] = {8.0, 256.0};  // contact offsets

}  // namespace

// True if the proxy is now at a minimum nearer to the device. With friction it stays.
bool ProxyMethod::escape(const Vec3& device) noexcept {
  if (has_friction_) return false;
  return tip_over(device) || (is_point_ && ((is_in_corner() && leave_corner(device)) || (is_wedged(device) && leave_wedge(device))));
}

bool ProxyMethod::is_better(const Vec3& device) const noexcept {
  return free_ || (device - proxy_).norm() < (device - equilibrium_.proxy).norm() - kLeastGain * contact_offset_;
}

// A proxy held by an edge or vertex with the device beyond it is in unstable balance, like a ball on a crest. So is one on the very
// boundary of a face, and a sphere held so by two faces. It is moved to either side: across the edge, or along the line of the two faces,
// or off the face that hardly holds it.
bool ProxyMethod::tip_over(const Vec3& device) noexcept {
  double most = 0.0;
  for (int i = 0; i < active_count_; ++i) most = std::max(most, multipliers_[i]);
  std::array<int, 3> strong = {};
  int count = 0;
  for (int i = 0; i < active_count_; ++i) {
    if (multipliers_[i] > kFlat * most) strong[count++] = i;
  }
  if (is_point_ && (count > 2 || (count == 2 && !is_in_corner()))) return false;  // a concave edge or vertex
  int balanced = -1;
  for (int i = 0; i < count; ++i) {
    const Contact& contact = contacts_[strong[i]];
    const Separation& at = contact.separation;
    if ((device - at.nearest).dot(at.normal) >= 0.0) continue;
    if (at.feature == Feature::face && contact.shape.boundary(at.nearest).distance > kNearBoundary * contact_offset_) continue;
    if (balanced < 0 || multipliers_[strong[i]] > multipliers_[balanced]) balanced = strong[i];
  }
  if (balanced < 0) return false;
  const Contact contact = contacts_[balanced];
  const Vec3& normal = contact.separation.normal;
  const Vec3 crossing =
      count == 2 ? contacts_[strong[0]].separation.normal.cross(contacts_[strong[1]].separation.normal) : Vec3(Vec3::Zero());
  const bool is_fold = crossing.norm() > kLevel;
  Vec3 first = is_fold ? crossing
               : contact.separation.feature == Feature::vertex
                   ? Vec3(Vec3::Zero())
                   : normal.cross(contact.shape.edge(contact.shape.boundary(contact.separation.nearest).edge));
  first = first.isZero(0.0) ? normal.unitOrthogonal() : Vec3(first.normalized());
  const Vec3 second = normal.cross(first);
  const double tip_distance = std::max(std::sqrt(contact_offset_ * clearance_.offset),
                                       2.0 * kNearBoundary * contact_offset_);  // on an arc round an edge: climbs half a contact offset
  std::array<Vec3, 4> directions = {first, -first, second, -second};
  int direction_count = 4;
  if (is_fold) {
    const Vec3& other = contacts_[strong[0] == balanced ? strong[1] : strong[0]].separation.normal;
    directions[2] = (other - other.dot(normal) * normal).normalized();
    const Vec3 goal = device - proxy_;
    direction_count =
        -goal.dot(directions[2]) <= 2.0 * tip_distance / clearance_.offset * goal.norm() ? 3 : 2;  // otherwise it would climb more
  }
  save(equilibrium_);
  for (const Vec3& sideways : std::span(directions).first(static_cast<std::size_t>(direction_count))) {
    if (tip(device, tip_distance * sideways)) return true;
    restore(equilibrium_);
  }
  return false;
}

bool ProxyMethod::tip(const Vec3& device, const Vec3& sideways) noexcept {
  ++counters_.attempts;
  if (advance(sideways)) return false;
  descend(device);
  return is_better(device);
}

bool ProxyMethod::is_in_corner() const noexcept {
  for (int i = 0; i < active_count_; ++i) {
    const Contact& contact = contacts_[i];
    for (int k = 0; k < 3; ++k) {
      if ((contact.separation.nearest - contact.shape.corner(k)).norm() <= kBeside * contact_offset_) return true;
    }
  }
  return false;
}

// Collects the edges at the vertex. If any direction on the surface leads nearer to the device, so does one of these edges: a direction on
// a face lies between two of its edges, and one of those leads nearer too.
void ProxyMethod::find_exits() noexcept {
  if ((proxy_ - exits_from_).norm() <= kLeastGain * contact_offset_) return;
  exits_from_ = proxy_;
  exit_count_ = 0;
  const double near = kBeside * contact_offset_ + clearance_.offset;
  geometry_.for_each_overlapping(Box{proxy_.array() - near, proxy_.array() + near}, [&](std::uint32_t triangle) {
    for (int k = 0; k < 3; ++k) {
      const Vec3& corner = geometry_.corner(triangle, k);
      if ((corner - proxy_).norm() > near) continue;
      for (const int other : {(k + 1) % 3, (k + 2) % 3}) {
        const Vec3 edge = geometry_.corner(triangle, other) - corner;
        if (exit_count_ < kMaxExits && !edge.isZero(0.0)) exits_[exit_count_++] = {edge.normalized(), false};
      }
    }
  });
}

bool ProxyMethod::leave_corner(const Vec3& device) noexcept {
  find_exits();
  const Vec3 goal = device - proxy_;
  const double least = kFlat * goal.norm() + kLeastGain * contact_offset_;
  for (int i = 0; i < exit_count_; ++i) {
    Exit& exit = exits_[i];
    const double gain = exit.direction.dot(goal);
    if (exit.closed || gain <= least) continue;
    save(equilibrium_);
    if (leave_along(device, gain * exit.direction, exit.closed)) return true;
  }
  return false;
}

// Two planes that nearly face each other, in a gap no wider than a few contact offsets, have multipliers much larger than the pull.
bool ProxyMethod::is_wedged(const Vec3& device) const noexcept {
  constexpr double kHard = 4.0;
  return active_count_ == 2 && multipliers_[0] > kHard * (device - proxy_).norm();
}

bool ProxyMethod::leave_wedge(const Vec3& device) noexcept {
  save(equilibrium_);
  const Vec3 goal = device - proxy_;
  for (int i = -1; i < equilibrium_.active_count; ++i) {
    const Vec3 normal = i < 0 ? Vec3(Vec3::Zero()) : equilibrium_.separations[i].normal;
    bool closed = false;
    if (leave_along(device, goal - goal.dot(normal) * normal, closed)) return true;
  }
  return false;
}

// Moves the proxy from its minimum, lifted over everything near. True if it then settles nearer to the device; otherwise it is restored.
// `closed` is set if the motion is blocked at once.
bool ProxyMethod::leave_along(const Vec3& device, const Vec3& motion, bool& closed) noexcept {
  closed = true;
  for (const Lift lift_over : {Lift::triangles, Lift::planes}) {
    for (const double height : kHeights) {
      if (!lift(height * contact_offset_, lift_over)) continue;
      const Vec3 lifted = proxy_;
      advance(motion);
      if ((proxy_ - lifted).norm() > 8.0 * height * contact_offset_) {
        closed = false;
        descend(device);
        if (is_better(device)) return true;
      }
      restore(equilibrium_);
    }
  }
  return false;
}

// The normal of a triangle's plane on the proxy's side, which the orientation of the active faces tells; zero if none does.
Vec3 ProxyMethod::normal_to_proxy(std::uint32_t triangle) const noexcept {
  const auto oriented_normal = [this](std::uint32_t t) {
    const Vec3& a = geometry_.corner(t, 0);
    return accurate_cross(geometry_.corner(t, 1) - a, geometry_.corner(t, 2) - a);
  };
  const Vec3 normal = oriented_normal(triangle);
  const double length = normal.norm();
  for (int i = 0; i < contact_count_ && length > 0.0; ++i) {
    const Separation& s = contacts_[i].separation;
    if (s.feature == Feature::face)
      return normal * (oriented_normal(contacts_[i].triangle).dot(s.normal) > 0.0 ? 1.0 / length : -1.0 / length);
  }
  return Vec3::Zero();
}

// Lifts the proxy over all triangles near, or over the planes of all faces near, which also opens the paths hidden behind a convex edge.
// Returns false, and moves nothing, if there is no room.
bool ProxyMethod::lift(double height, Lift over) noexcept {
  ++counters_.attempts;
  const double near = 2.0 * height;
  int count = 0;
  geometry_.for_each_overlapping(Box{proxy_.array() - near, proxy_.array() + near}, [&](std::uint32_t triangle) {
    const Separation s = geometry_.separation(triangle, proxy_);
    if (count == kMaxContacts || s.distance > near || !can_touch(triangle, proxy_)) return;
    if (over == Lift::triangles) {
      planes_[count++] = {s.normal, height - s.distance};
    } else if (const Vec3 normal = normal_to_proxy(triangle); !normal.isZero(0.0)) {
      planes_[count++] = {normal, height - normal.dot(proxy_ - s.nearest)};
    }
  });
  const ConstrainedMotion up =
      constrain_motion(Vec3::Zero(), std::span<const ContactPlane>(planes_.data(), static_cast<std::size_t>(count)));
  if (!up.solved || up.motion.norm() > 64.0 * height) return false;
  if (advance(up.motion)) {
    restore(equilibrium_);
    return false;
  }
  contact_count_ = 0;
  return true;
}

}  // namespace hapton
