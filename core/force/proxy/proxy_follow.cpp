// One step: over the surface from event to event where it is walkable, through the air between, and by sweeps elsewhere.
#include <algorithm>

#include "core/force/proxy/proxy_method.h"
#include "core/math/side_sign.h"

namespace hapton {
namespace {

constexpr double kFarFromScene = 4.0;                 // local units: farther out positions are too coarse to be exact on the surface
constexpr double kLift = 0.5 * SurfacePoint::kClear;  // how far off the surface a flight begins
constexpr int kMostLegs = 64;                         // times that a step leaves the surface

bool is_far(const Vec3& p) { return !(p.cwiseAbs().maxCoeff() <= kFarFromScene); }

}  // namespace

void ProxyMethod::follow(const Vec3& last, const Vec3& device) noexcept {
  sweeps_left_ = kMaxSweeps;
  double time = 0.0;
  if (is_point_ && (surface_.stands() || free_ || stand_on_surface())) {
    if (follow_surface(last, device, time)) return;
    if (surface_.stands()) lift_off_surface();
  }
  if (sphere_ != nullptr && follow_offset(last, device, time)) return;
  ++counters_.careful;
  const Vec3 from = on_way(last, device, time);
  if (free_ && is_point_) clear_start();
  if (!free_ && time > 0.0) solve(from);
  follow_by_sweeps(from, device);
}

// True when the surface alone led to the end of the step. Else the proxy stands on the surface, or is free, with the device at `time`.
bool ProxyMethod::follow_surface(const Vec3& last, const Vec3& device, double& time) noexcept {
  using Outcome = SurfaceFollower::Outcome;
  if (is_far(last) || is_far(device)) return false;
  Outcome outcome = Outcome::settled;
  bool has_settled = !short_of_rest_;
  short_of_rest_ = false;
  for (int leg = 0; leg < kMostLegs; ++leg) {
    const Vec3 here = on_way(last, device, time);
    if (!surface_.stands()) {
      double until = 1.0;
      const Met met = fly(here, device, false, until);
      if (met == Met::nothing) {
        settle_at(device);
        return true;
      }
      if (met == Met::other) {
        settle_at(here);
        return false;
      }
      time = std::min(1.0, time + (1.0 - time) * until);
      has_settled = true;
    }
    outcome = has_settled ? surface_.follow(last, device, time) : surface_.descend(here);
    if (outcome == Outcome::unwalkable) return false;
    if (outcome == Outcome::exhausted) {
      ++counters_.exhausted;
      short_of_rest_ = true;
    }
    if (outcome == Outcome::exhausted || (outcome == Outcome::settled && time >= 1.0)) {
      hold_by_surface(device);
      return true;
    }
    has_settled = true;
    if (outcome == Outcome::settled) continue;
    ++counters_.flights;
    if (outcome == Outcome::released) {
      double until = 1.0;
      const Met met = fly(surface_.at().lifted_towards(device, kLift), device, false, until);
      if (met == Met::other) return false;
      if (met == Met::nothing) {
        surface_.leave();
        settle_at(device);
        return true;
      }
      time = std::min(1.0, time + (1.0 - time) * until);
      continue;
    }
    double until = 1.0;
    const Vec3 at = on_way(last, device, time);
    const Met met = fly(surface_.at().lifted_towards(at, kLift), at, surface_.slides(), until);
    if (met == Met::other) return false;
    if (met == Met::nothing) {
      surface_.leave();
      settle_at(at);
    }
    has_settled = met == Met::nothing;
  }
  ++counters_.exhausted;
  short_of_rest_ = surface_.stands();
  if (surface_.stands()) {
    hold_by_surface(device);
    return true;
  }
  return false;
}

// Straight through the air. What it meets first holds the proxy, where it is walkable; `time` says when. From triangles that are not it
// stays as far off as sweeps do, or they take over.
ProxyMethod::Met ProxyMethod::fly(const Vec3& from, const Vec3& to, bool slides, double& time) noexcept {
  Met met = Met::nothing;
  std::uint32_t first = 0;
  TouchGeometry::Hit hit;
  const Vec3 motion = to - from;
  geometry_.visit_along(from, to, clearance_.rest, [&](std::uint32_t id, double until) {
    if (!geometry_.is_walkable(id)) {
      if (!can_touch(id, from) || time_to_block(TriangleView{geometry_, id}, from, motion, until, clearance_) > until) return until;
      met = Met::other;
      return 0.0;
    }
    const TouchGeometry::Hit at = geometry_.pierce(id, from, to);
    if (met == Met::other || at.time > until || (at.time == until && met == Met::walkable)) return until;
    if (at.from_back && !surfaces_[geometry_.mesh_of(id)].two_sided) return until;
    if (!is_seen_from(from, to, id, at.from_back, from + at.time * motion)) return until;
    met = Met::walkable;
    first = id;
    hit = at;
    return hit.time;
  });
  if (met != Met::walkable) return met;
  time = hit.time;
  const ContactTriangle shape = shape_of(first);
  const Vec3 at = from + time * motion;
  const Vec3 on_face = at - shape.normal().dot(at - shape.corner(0)) * shape.normal();
  return surface_.land(first, hit.from_back, on_face, slides) ? Met::walkable : Met::other;
}

// Near an edge a segment that cuts it goes through both its triangles within what rounding can tell apart. Only that is met which p sees: p
// lies on that side of the wedge that the two form.
bool ProxyMethod::is_seen_from(const Vec3& p, const Vec3& to, std::uint32_t id, bool back, const Vec3& hit) noexcept {
  constexpr double kNearEdge = 0x1p-40;
  const ContactTriangle shape = shape_of(id);
  const auto in_front = [](const ContactTriangle& of, const Vec3& point) {
    return side_sign(of.corner(0), of.corner(1), of.corner(2), point) > 0.0;
  };
  for (int k = 0; k < 3; ++k) {
    if (shape.inside(k, hit) > kNearEdge * shape.length(k)) continue;
    const TouchGeometry::Across across = geometry_.across(id, k);
    if (!across.exists || across.id == id) continue;
    const double along = shape.along(k, hit) * shape.length(k);
    if (!(along > kNearEdge)) {
      if (!is_vertex_seen_from(p, to, id, back, k, hit)) return false;
      continue;
    }
    if (!(shape.length(k) - along > kNearEdge)) continue;         // the vertex is the next edge's
    if (geometry_.pierce(across.id, p, to).time > 1.0) continue;  // it does not go through both
    const ContactTriangle other = shape_of(across.id);
    const bool other_back = back != across.flips;
    const bool is_convex = in_front(other, shape.corner((k + 2) % 3)) == other_back;
    const bool before = in_front(shape, p) != back;
    const bool before_other = in_front(other, p) != other_back;
    if (!(is_convex ? before || before_other : before && before_other)) return false;
  }
  return true;
}

// The same at corner k, where more than two triangles have a say. Which sides it goes through alternates, so where one is met once more
// than the other, it is the first.
bool ProxyMethod::is_vertex_seen_from(const Vec3& p, const Vec3& to, std::uint32_t id, bool back, int k, const Vec3& hit) noexcept {
  SurfacePoint& vertex = glance_;
  if (!vertex.land(id, back, hit) || !vertex.reach_vertex(k)) return true;
  int more = 0;
  for (const SurfacePoint::FanFacet& facet : vertex.fan()) {
    const TouchGeometry::Hit at = geometry_.pierce(facet.id, p, to);
    if (at.time <= 1.0) more += at.from_back == facet.back ? 1 : -1;
  }
  return more != 0 ? more > 0 : vertex.is_before_fan(p);
}

// A free proxy may be nearer to a walkable triangle than sweeps keep: it is moved off, to the side that it is on.
void ProxyMethod::clear_start() noexcept {
  int count = 0;
  geometry_.for_each_overlapping(Box{proxy_, proxy_}.inflated(clearance_.rest), [&](std::uint32_t id) {
    const ContactTriangle shape = shape_of(id);
    const Separation at = shape.separation(proxy_);
    if (at.distance >= clearance_.rest || count == kMaxTouching || !can_touch(id, proxy_)) return;
    Vec3 normal = at.normal;
    if (at.feature == Feature::face) {
      const double side = side_sign(shape.corner(0), shape.corner(1), shape.corner(2), proxy_);
      if ((side > 0.0) != (shape.normal().dot(normal) > 0.0)) normal = -normal;
    }
    planes_[count++] = {normal, clearance_.rest - normal.dot(proxy_ - at.nearest)};
  });
  if (count == 0) return;
  const ConstrainedMotion off =
      constrain_motion(Vec3::Zero(), std::span<const ContactPlane>(planes_.data(), static_cast<std::size_t>(count)));
  if (off.solved && off.motion.norm() <= kBeside * hover_) proxy_ += off.motion;
}

// The surface holds the proxy at the end of a step.
void ProxyMethod::hold_by_surface(const Vec3& device) noexcept {
  proxy_ = surface_.at().lifted(hover_);
  off_ = hover_;
  free_ = false;
  sliding_ = surface_.slides();
  std::array<SurfacePoint::Contact, 3> contacts;
  pushing_count_ = shading_ > 0.0 ? surface_.at().find_contacts(device, contacts) : 0;
  touching_count_ = std::max(pushing_count_, 1);
  touching_[0].triangle = surface_.at().a().id;
  for (int i = 0; i < pushing_count_; ++i) {
    touching_[i].triangle = contacts[i].triangle;
    touching_[i].separation = {0.0, contacts[i].normal, proxy_, Feature::face};
    push_[i] = contacts[i].multiplier;
  }
}

// Off the surface by what sweeps keep, a little off every edge, so that nothing beyond one is nearer.
void ProxyMethod::lift_off_surface() noexcept {
  const SurfacePoint::Inside from = surface_.at().inside(kBeside * hover_);
  surface_.leave();
  proxy_ = from.point + clearance_.rest * from.normal;
  off_ = hover_;
  if (sphere_ != nullptr) sphere_->leave();
  free_ = false;
  sliding_ = surface_.slides();
  Touch& touch = touching_[0];
  touch.triangle = from.triangle;
  touch.place = Neighbourhood::kNowhere;
  touch.shape = shape_of(from.triangle);
  touch.separation = {clearance_.rest, from.normal, from.point, Feature::face};
  touching_count_ = 1;
  pushing_count_ = 0;
  forget_near();
}

// A proxy that sweeps have brought to rest on walkable faces goes on over the surface.
bool ProxyMethod::stand_on_surface() noexcept {
  if (pushing_count_ < 1 || pushing_count_ > 2) return false;
  const auto faces_of = [&](const Touch& touch) {
    return touch.separation.feature == Feature::face && geometry_.is_walkable(touch.triangle);
  };
  for (int i = 0; i < pushing_count_; ++i) {
    if (!faces_of(touching_[i])) return false;
  }
  const Touch& touch = touching_[0];
  const ContactTriangle shape = shape_of(touch.triangle);
  const bool back = shape.normal().dot(touch.separation.normal) < 0.0;
  const Vec3 p = proxy_ - shape.normal().dot(proxy_ - shape.corner(0)) * shape.normal();
  if (pushing_count_ == 1) {
    for (int k = 0; k < 3; ++k) {
      if (!(shape.inside(k, p) > 0.0)) return false;
    }
    short_of_rest_ = surface_.land(touch.triangle, back, p, sliding_);
    return short_of_rest_;
  }
  for (int k = 0; k < 3; ++k) {
    const TouchGeometry::Across across = geometry_.across(touch.triangle, k);
    if (!across.exists || across.id != touching_[1].triangle) continue;
    const double along = shape.along(k, p);
    const Vec3 on_edge = shape.corner(k) + along * shape.edge(k);
    if (!(along > 0.0 && along < 1.0) || (on_edge - p).norm() > kBeside * hover_) return false;
    short_of_rest_ = surface_.land_on_edge(touch.triangle, back, k, on_edge, sliding_);
    return short_of_rest_;
  }
  return false;
}

}  // namespace hapton
