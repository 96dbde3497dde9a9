// One step of the proxy: from event to event where the surface is walkable, straight through free space, by sweeps elsewhere.
#include <algorithm>

#include "core/force/proxy/proxy_method.h"
#include "core/math/side_sign.h"

namespace hapton {
namespace {

constexpr double kFarFromScene = 4.0;                 // local units: positions farther out are too coarse to be exact on the surface
constexpr double kLift = 0.5 * SurfacePoint::kClear;  // distance from the surface at which a flight starts
constexpr int kMostLegs = 64;                         // flights in one step

bool is_far(const Vec3& p) { return !(p.cwiseAbs().maxCoeff() <= kFarFromScene); }

}  // namespace

void ProxyMethod::follow(const Vec3& last, const Vec3& device) noexcept {
  sweeps_left_ = kMaxSweeps;
  double time = 0.0;
  if (is_point_ && (surface_.is_on_surface() || free_ || land_on_surface())) {
    if (follow_surface(last, device, time)) return;
    if (surface_.is_on_surface()) lift_off_surface();
  }
  if (sphere_ != nullptr && follow_offset(last, device, time)) return;
  ++counters_.swept;
  const Vec3 from = on_path(last, device, time);
  if (free_ && is_point_) clear_start();
  if (!free_ && time > 0.0) solve(from);
  follow_by_sweeps(from, device);
}

// True if the step was finished on the surface and in free space. Otherwise the proxy is on the surface, or free, with the device at
// `time`.
bool ProxyMethod::follow_surface(const Vec3& last, const Vec3& device, double& time) noexcept {
  using Outcome = SurfaceFollower::Outcome;
  if (is_far(last) || is_far(device)) return false;
  Outcome outcome = Outcome::settled;
  bool has_settled = !unconverged_;
  unconverged_ = false;
  for (int leg = 0; leg < kMostLegs; ++leg) {
    const Vec3 here = on_path(last, device, time);
    if (!surface_.is_on_surface()) {
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
      unconverged_ = true;
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
    const Vec3 at = on_path(last, device, time);
    const Met met = fly(surface_.at().lifted_towards(at, kLift), at, surface_.slides(), until);
    if (met == Met::other) return false;
    if (met == Met::nothing) {
      surface_.leave();
      settle_at(at);
    }
    has_settled = met == Met::nothing;
  }
  ++counters_.exhausted;
  unconverged_ = surface_.is_on_surface();
  if (surface_.is_on_surface()) {
    hold_by_surface(device);
    return true;
  }
  return false;
}

// A straight motion through free space. The first walkable triangle on it holds the proxy, and `time` is set to the contact. Returns
// Met::other if the path comes as near to another triangle as sweeps keep.
ProxyMethod::Met ProxyMethod::fly(const Vec3& from, const Vec3& to, bool slides, double& time) noexcept {
  Met met = Met::nothing;
  std::uint32_t first = 0;
  TouchGeometry::Hit hit;
  const Vec3 motion = to - from;
  geometry_.visit_along(from, to, clearance_.offset, [&](std::uint32_t id, double until) {
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

// A segment that crosses an edge passes through both its triangles within rounding. Only the one that p sees counts: p must lie on its side
// of the wedge that the two form.
bool ProxyMethod::is_seen_from(const Vec3& p, const Vec3& to, std::uint32_t id, bool back, const Vec3& hit) noexcept {
  constexpr double kNearEdge = 0x1p-40;
  const ContactTriangle shape = shape_of(id);
  const auto in_front = [](const ContactTriangle& of, const Vec3& point) {
    return side_sign(of.corner(0), of.corner(1), of.corner(2), point) > 0.0;
  };
  for (int k = 0; k < 3; ++k) {
    if (shape.inside(k, hit) > kNearEdge * shape.length(k)) continue;
    const TouchGeometry::Adjacent adjacent = geometry_.adjacent(id, k);
    if (!adjacent.exists || adjacent.id == id) continue;
    const double along = shape.along(k, hit) * shape.length(k);
    if (!(along > kNearEdge)) {
      if (!is_vertex_seen_from(p, to, id, back, k, hit)) return false;
      continue;
    }
    if (!(shape.length(k) - along > kNearEdge)) continue;           // the vertex belongs to the next edge
    if (geometry_.pierce(adjacent.id, p, to).time > 1.0) continue;  // the segment does not cross both
    const ContactTriangle other = shape_of(adjacent.id);
    const bool other_back = back != adjacent.flips;
    const bool is_convex = in_front(other, shape.corner((k + 2) % 3)) == other_back;
    const bool before = in_front(shape, p) != back;
    const bool before_other = in_front(other, p) != other_back;
    if (!(is_convex ? before || before_other : before && before_other)) return false;
  }
  return true;
}

// The same at a vertex with more than two triangles. The sides that the segment crosses alternate, so the one crossed once more than the
// other is first.
bool ProxyMethod::is_vertex_seen_from(const Vec3& p, const Vec3& to, std::uint32_t id, bool back, int k, const Vec3& hit) noexcept {
  SurfacePoint& vertex = vertex_probe_;
  if (!vertex.land(id, back, hit) || !vertex.reach_vertex(k)) return true;
  int more = 0;
  for (const SurfacePoint::FanFacet& facet : vertex.fan()) {
    const TouchGeometry::Hit at = geometry_.pierce(facet.id, p, to);
    if (at.time <= 1.0) more += at.from_back == facet.back ? 1 : -1;
  }
  return more != 0 ? more > 0 : vertex.is_before_fan(p);
}

// A free proxy may be nearer to a walkable triangle than sweeps keep: moves it off, on its own side.
void ProxyMethod::clear_start() noexcept {
  int count = 0;
  geometry_.for_each_overlapping(Box{proxy_, proxy_}.inflated(clearance_.offset), [&](std::uint32_t id) {
    const ContactTriangle shape = shape_of(id);
    const Separation at = shape.separation(proxy_);
    if (at.distance >= clearance_.offset || count == kMaxContacts || !can_touch(id, proxy_)) return;
    Vec3 normal = at.normal;
    if (at.feature == Feature::face) {
      const double side = side_sign(shape.corner(0), shape.corner(1), shape.corner(2), proxy_);
      if ((side > 0.0) != (shape.normal().dot(normal) > 0.0)) normal = -normal;
    }
    planes_[count++] = {normal, clearance_.offset - normal.dot(proxy_ - at.nearest)};
  });
  if (count == 0) return;
  const ConstrainedMotion off =
      constrain_motion(Vec3::Zero(), std::span<const ContactPlane>(planes_.data(), static_cast<std::size_t>(count)));
  if (off.solved && off.motion.norm() <= kBeside * contact_offset_) proxy_ += off.motion;
}

// At the end of a step that the surface holds.
void ProxyMethod::hold_by_surface(const Vec3& device) noexcept {
  proxy_ = surface_.at().lifted(contact_offset_);
  active_offset_ = contact_offset_;
  free_ = false;
  sliding_ = surface_.slides();
  std::array<SurfacePoint::Contact, 3> contacts;
  active_count_ = shading_ > 0.0 ? surface_.at().find_contacts(device, contacts) : 0;
  contact_count_ = std::max(active_count_, 1);
  contacts_[0].triangle = surface_.at().a().id;
  for (int i = 0; i < active_count_; ++i) {
    contacts_[i].triangle = contacts[i].triangle;
    contacts_[i].separation = {0.0, contacts[i].normal, proxy_, Feature::face};
    multipliers_[i] = contacts[i].multiplier;
  }
}

// Lifts the proxy to the distance that sweeps keep and away from every edge, so that nothing beyond an edge is nearer.
void ProxyMethod::lift_off_surface() noexcept {
  const SurfacePoint::Inside from = surface_.at().inside(kBeside * contact_offset_);
  surface_.leave();
  proxy_ = from.point + clearance_.offset * from.normal;
  active_offset_ = contact_offset_;
  if (sphere_ != nullptr) sphere_->stop_tracking();
  free_ = false;
  sliding_ = surface_.slides();
  Contact& contact = contacts_[0];
  contact.triangle = from.triangle;
  contact.slot = TriangleCache::kNoSlot;
  contact.shape = shape_of(from.triangle);
  contact.separation = {clearance_.offset, from.normal, from.point, Feature::face};
  contact_count_ = 1;
  active_count_ = 0;
  forget_near();
}

// Puts a proxy that sweeps have settled on walkable faces back onto the surface.
bool ProxyMethod::land_on_surface() noexcept {
  if (active_count_ < 1 || active_count_ > 2) return false;
  const auto faces_of = [&](const Contact& contact) {
    return contact.separation.feature == Feature::face && geometry_.is_walkable(contact.triangle);
  };
  for (int i = 0; i < active_count_; ++i) {
    if (!faces_of(contacts_[i])) return false;
  }
  const Contact& contact = contacts_[0];
  const ContactTriangle shape = shape_of(contact.triangle);
  const bool back = shape.normal().dot(contact.separation.normal) < 0.0;
  const Vec3 p = proxy_ - shape.normal().dot(proxy_ - shape.corner(0)) * shape.normal();
  if (active_count_ == 1) {
    for (int k = 0; k < 3; ++k) {
      if (!(shape.inside(k, p) > 0.0)) return false;
    }
    unconverged_ = surface_.land(contact.triangle, back, p, sliding_);
    return unconverged_;
  }
  for (int k = 0; k < 3; ++k) {
    const TouchGeometry::Adjacent adjacent = geometry_.adjacent(contact.triangle, k);
    if (!adjacent.exists || adjacent.id != contacts_[1].triangle) continue;
    const double along = shape.along(k, p);
    const Vec3 on_edge = shape.corner(k) + along * shape.edge(k);
    if (!(along > 0.0 && along < 1.0) || (on_edge - p).norm() > kBeside * contact_offset_) return false;
    unconverged_ = surface_.land_on_edge(contact.triangle, back, k, on_edge, sliding_);
    return unconverged_;
  }
  return false;
}

}  // namespace hapton
