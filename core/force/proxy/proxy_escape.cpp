// How the proxy gets out of rests that are none. The hover keeps it off the surface; on an edge, or where a fold narrows at a corner, so
// small a ball can come to rest on a maximum or against a step no higher than itself, where a point would go on.
#include <algorithm>
#include <cmath>

#include "core/force/proxy/proxy_method.h"

namespace hapton {
namespace {

constexpr double kLeastGain = 4.0;           // hovers: a step that nobody feels
constexpr double kBorder = 16.0;             // hovers: a face's contact as near to its border may stand on the edge
constexpr double kFlat = 0x1p-20;            // slopes below this are level
constexpr double kLevel = 0x1p-10;           // between planes that hold a sphere: less is one plane
constexpr double kHeights[] = {8.0, 256.0};  // hovers

}  // namespace

// True when the proxy now rests nearer to the device. Friction holds it where it is.
bool ProxyMethod::escape(const Vec3& device) noexcept {
  if (has_friction_) return false;
  return tip_over(device) || (is_point_ && ((is_in_corner() && leave_corner(device)) || (is_jammed(device) && leave_jam(device))));
}

bool ProxyMethod::is_better(const Vec3& device) const noexcept {
  return free_ || (device - proxy_).norm() < (device - rest_.proxy).norm() - kLeastGain * hover_;
}

// A proxy held by an edge or corner with the device beyond it stands like a ball on a ridge: it is pushed to either side. So does one on
// the very border of a face, and a sphere held so by two: along their line, or off the one that hardly holds it.
bool ProxyMethod::tip_over(const Vec3& device) noexcept {
  double most = 0.0;
  for (int i = 0; i < pushing_count_; ++i) most = std::max(most, push_[i]);
  std::array<int, 3> strong = {};
  int count = 0;
  for (int i = 0; i < pushing_count_; ++i) {
    if (push_[i] > kFlat * most) strong[count++] = i;
  }
  if (is_point_ && (count > 2 || (count == 2 && !is_in_corner()))) return false;  // a fold or pit
  int balanced = -1;
  for (int i = 0; i < count; ++i) {
    const Touch& touch = touching_[strong[i]];
    const Separation& at = touch.separation;
    if ((device - at.nearest).dot(at.normal) >= 0.0) continue;
    if (at.feature == Feature::face && touch.shape.border(at.nearest).distance > kBorder * hover_) continue;
    if (balanced < 0 || push_[strong[i]] > push_[balanced]) balanced = strong[i];
  }
  if (balanced < 0) return false;
  const Touch touch = touching_[balanced];
  const Vec3& normal = touch.separation.normal;
  const Vec3 fold = count == 2 ? touching_[strong[0]].separation.normal.cross(touching_[strong[1]].separation.normal) : Vec3(Vec3::Zero());
  const bool is_fold = fold.norm() > kLevel;
  Vec3 first = is_fold ? fold
               : touch.separation.feature == Feature::vertex
                   ? Vec3(Vec3::Zero())
                   : normal.cross(touch.shape.edge(touch.shape.border(touch.separation.nearest).edge));
  first = first.isZero(0.0) ? normal.unitOrthogonal() : Vec3(first.normalized());
  const Vec3 second = normal.cross(first);
  const double far = std::max(std::sqrt(hover_ * clearance_.rest), 2.0 * kBorder * hover_);  // round an edge: climbs half a hover
  std::array<Vec3, 4> ways = {first, -first, second, -second};
  int way_count = 4;
  if (is_fold) {
    const Vec3& other = touching_[strong[0] == balanced ? strong[1] : strong[0]].separation.normal;
    ways[2] = (other - other.dot(normal) * normal).normalized();
    const Vec3 goal = device - proxy_;
    way_count = -goal.dot(ways[2]) <= 2.0 * far / clearance_.rest * goal.norm() ? 3 : 2;  // else it would climb by more
  }
  save(rest_);
  for (const Vec3& sideways : std::span(ways).first(static_cast<std::size_t>(way_count))) {
    if (tip(device, far * sideways)) return true;
    restore(rest_);
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
  for (int i = 0; i < pushing_count_; ++i) {
    const Touch& touch = touching_[i];
    for (int k = 0; k < 3; ++k) {
      if ((touch.separation.nearest - touch.shape.corner(k)).norm() <= kBeside * hover_) return true;
    }
  }
  return false;
}

// All edges that begin here. A point that can get any nearer to the device without leaving the surface can do so along one of them: the
// way along a face lies between two of its edges, and one of those leads nearer, too.
void ProxyMethod::find_exits() noexcept {
  if ((proxy_ - exits_from_).norm() <= kLeastGain * hover_) return;
  exits_from_ = proxy_;
  exit_count_ = 0;
  const double near = kBeside * hover_ + clearance_.rest;
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
  const double least = kFlat * goal.norm() + kLeastGain * hover_;
  for (int i = 0; i < exit_count_; ++i) {
    Exit& exit = exits_[i];
    const double gain = exit.direction.dot(goal);
    if (exit.closed || gain <= least) continue;
    save(rest_);
    if (leave_along(device, gain * exit.direction, exit.closed)) return true;
  }
  return false;
}

// Between two planes that nearly face each other, a slit no wider than a few hovers, the planes push much harder than the device pulls.
bool ProxyMethod::is_jammed(const Vec3& device) const noexcept {
  constexpr double kHard = 4.0;
  return pushing_count_ == 2 && push_[0] > kHard * (device - proxy_).norm();
}

bool ProxyMethod::leave_jam(const Vec3& device) noexcept {
  save(rest_);
  const Vec3 goal = device - proxy_;
  for (int i = -1; i < rest_.pushing_count; ++i) {
    const Vec3 normal = i < 0 ? Vec3(Vec3::Zero()) : rest_.separations[i].normal;
    bool closed = false;
    if (leave_along(device, goal - goal.dot(normal) * normal, closed)) return true;
  }
  return false;
}

// From where the proxy rests, lifted over everything near: true when it now rests nearer to the device, else it is put back. `closed` tells
// that the motion is blocked at once.
bool ProxyMethod::leave_along(const Vec3& device, const Vec3& motion, bool& closed) noexcept {
  closed = true;
  for (const Lift lift_over : {Lift::things, Lift::planes}) {
    for (const double height : kHeights) {
      if (!lift(height * hover_, lift_over)) continue;
      const Vec3 lifted = proxy_;
      advance(motion);
      if ((proxy_ - lifted).norm() > 8.0 * height * hover_) {
        closed = false;
        descend(device);
        if (is_better(device)) return true;
      }
      restore(rest_);
    }
  }
  return false;
}

// A face's plane, seen from the side the proxy is on: by the side of the faces that push, wound as this one; zero where none tells.
Vec3 ProxyMethod::normal_to_proxy(std::uint32_t triangle) const noexcept {
  const auto wound = [this](std::uint32_t t) {
    const Vec3& a = geometry_.corner(t, 0);
    return accurate_cross(geometry_.corner(t, 1) - a, geometry_.corner(t, 2) - a);
  };
  const Vec3 normal = wound(triangle);
  const double length = normal.norm();
  for (int i = 0; i < touching_count_ && length > 0.0; ++i) {
    const Separation& s = touching_[i].separation;
    if (s.feature == Feature::face) return normal * (wound(touching_[i].triangle).dot(s.normal) > 0.0 ? 1.0 / length : -1.0 / length);
  }
  return Vec3::Zero();
}

// Lifts the proxy over everything near, or over the planes of all faces near: from there every way along the faces round a corner is open,
// also those behind a ridge. False, and nothing moved, where there is no room.
bool ProxyMethod::lift(double height, Lift over) noexcept {
  ++counters_.attempts;
  const double near = 2.0 * height;
  int count = 0;
  geometry_.for_each_overlapping(Box{proxy_.array() - near, proxy_.array() + near}, [&](std::uint32_t triangle) {
    const Separation s = geometry_.separation(triangle, proxy_);
    if (count == kMaxTouching || s.distance > near || !can_touch(triangle, proxy_)) return;
    if (over == Lift::things) {
      planes_[count++] = {s.normal, height - s.distance};
    } else if (const Vec3 normal = normal_to_proxy(triangle); !normal.isZero(0.0)) {
      planes_[count++] = {normal, height - normal.dot(proxy_ - s.nearest)};
    }
  });
  const ConstrainedMotion up =
      constrain_motion(Vec3::Zero(), std::span<const ContactPlane>(planes_.data(), static_cast<std::size_t>(count)));
  if (!up.solved || up.motion.norm() > 64.0 * height) return false;
  if (advance(up.motion)) {
    restore(rest_);
    return false;
  }
  touching_count_ = 0;
  return true;
}

}  // namespace hapton
