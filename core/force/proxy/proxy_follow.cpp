// One step of the proxy: from event to event where the surface is walkable, straight through free space, by sweeps elsewhere.
#include <algorithm>
#include <limits>

#include "core/force/proxy/proxy_method.h"

namespace hapton {
namespace {

constexpr double kFarFromScene = 4.0;  // local units: positions farther out are too coarse to be exact on the surface
constexpr double kFlightStartHeight = 0.5 * SurfacePoint::kClear;  // distance from the surface at which a flight starts
constexpr double kNarrow = 8.0;  // contact offsets: a triangle whose middle is nearer to an edge than this has no room
constexpr int kMaxLegs = 64;     // flights in one step

bool is_far(const Vec3& p) { return !(p.cwiseAbs().maxCoeff() <= kFarFromScene); }

// The times, 0 to 1, between which a straight motion is not far from the scene. There are none if begin > end.
struct NearSpan {
  double begin = 0.0, end = 1.0;
};

NearSpan find_near_span(const Vec3& from, const Vec3& to) {
  NearSpan span;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {1.0, -1.0}) {
      const double beyond = side * from[axis] - kFarFromScene;
      const double beyond_then = side * to[axis] - kFarFromScene;
      if (beyond <= 0.0 && beyond_then <= 0.0) continue;
      if (beyond > 0.0 && beyond_then > 0.0) return {1.0, 0.0};
      const double crossing = beyond / (beyond - beyond_then);
      if (beyond > 0.0) {
        span.begin = std::max(span.begin, crossing);
      } else {
        span.end = std::min(span.end, crossing);
      }
    }
  }
  return span;
}

Vec3 clamped_near_scene(const Vec3& p) { return p.cwiseMax(-kFarFromScene).cwiseMin(kFarFromScene); }

}  // namespace

// With a point probe, the device's motion is split where it enters and where it leaves the region near the scene. Far out, the position of
// the device is too coarse to be exact on the surface, so a proxy in contact descends towards the point where the device enters.
void ProxyMethod::follow(const Vec3& last, const Vec3& device) noexcept {
  const NearSpan near = find_near_span(last, device);
  if (!is_point_ || near.begin > near.end || (near.begin == 0.0 && near.end == 1.0)) return follow_piece(last, device);
  const Vec3 enter = near.begin > 0.0 ? clamped_near_scene(on_path(last, device, near.begin)) : last;
  const Vec3 exit = near.end < 1.0 ? clamped_near_scene(on_path(last, device, near.end)) : device;
  if (near.begin > 0.0) arrive_from_far(enter);
  follow_piece(enter, exit);
  if (near.end < 1.0 && !carried_from_) follow_piece(exit, device);
}

// The device has come from far away to this position near the scene.
void ProxyMethod::arrive_from_far(const Vec3& device) noexcept {
  if (proxy_.is_free) return proxy_.settle_at(device);
  if (!surface_.is_on_surface()) sphere_.stop_tracking();
  is_unconverged_ = true;
}

void ProxyMethod::follow_piece(const Vec3& last, const Vec3& device) noexcept {
  double time = 0.0;
  if (is_point_ && (surface_.is_on_surface() || proxy_.is_free || land_on_surface())) {
    if (follow_surface(last, device, time)) return;
    if (surface_.is_on_surface()) lift_off_surface();
  }
  const bool may_follow =
      !swept_.must_go_on() && !(tries_.is_left_to_sweeps && proxy_.contact_count == 0) && tries_.failures < kMaxFailures;
  if (may_follow && follow_offset(last, device, time)) return;
  ++counters_.swept;
  if (may_follow && sphere_.is_in_slit()) return sweep_from_slit(last, device);
  active_offset_ = kContactOffset;
  if (proxy_.is_free && is_point_) move_start_off_surfaces();
  const Vec3 there = on_path(last, device, time);
  if (!proxy_.is_free && time > 0.0 && !sweep_to(there)) return carry(there);
  if (!sweep_to(device)) return carry(device);
  follow_after_sweep(last, device);
}

// The proxy stays in the slit if sweeps get it no nearer to the device.
void ProxyMethod::sweep_from_slit(const Vec3& last, const Vec3& device) noexcept {
  is_at_sphere_offset_ = true;
  const bool has_settled = sweep_to(device);
  if (has_settled && !is_nearer_than_sphere(device) && !sweep_past_slit(device)) return copy_sphere_state(device);
  sphere_.stop_tracking();
  if (!has_settled) return carry(device);
  follow_after_sweep(last, device);
}

bool ProxyMethod::is_nearer_than_sphere(const Vec3& device) const noexcept {
  return (proxy_.position - device).norm() < (sphere_.centre() - device).norm();
}

// In a wedge whose tip is far away, the sphere that stands for the point is held far from the tip, perhaps by a face that ends before the
// tip. A much smaller sphere gets past the end of this face. True: with the smaller sphere, the proxy comes nearer to the device, to a
// place where the larger sphere has room.
bool ProxyMethod::sweep_past_slit(const Vec3& device) noexcept {
  constexpr double kSmaller = 0x1p-6;  // share of the larger radius; slop and tolerance of such a sweep are still above rounding
  constexpr double kRoom = 0.75;       // share of the larger radius
  if (work_left_ <= 0) return false;
  swept_.keep_only(kSmaller * sphere_.offset());
  const bool has_settled = swept_.descend(proxy_, device, work_left_);
  work_left_ -= swept_.work();
  if (!has_settled) swept_.forget();
  if (!has_settled || proxy_.is_free) return has_settled;
  move_start_off_surfaces();  // without room, a sweep of the larger sphere would push the proxy far aside
  return is_nearer_than_sphere(device) && !is_nearer_to_surface(proxy_.position, kRoom * sphere_.offset());
}

// Lets the sphere follower go on. Without work left, it could only be interrupted, and would lose the contacts: then a point is carried, a
// few times in a motion and at least once for each sample. Where sweeps settle, the point is farther from surfaces than the follower's
// sphere, and in a wedge whose tip is far away, it may be held where that sphere is not.
void ProxyMethod::follow_after_sweep(const Vec3& last, const Vec3& device) noexcept {
  if (proxy_.is_free || swept_.is_shrunk()) return;
  if (work_left_ <= 0 && is_point_ && (last != device || ++tries_.sweep_carries <= kMaxFailures)) return carry(device);
  double here = 0.0;
  if (work_left_ > 0 && tries_.failures < kMaxFailures && !follow_offset(device, device, here) && sphere_.is_in_slit())
    copy_sphere_state(device);
}

// A sweep that begins nearer to a face than its clearance could pass through it: then it keeps only the sphere follower's distance.
bool ProxyMethod::sweep_to(const Vec3& device) noexcept {
  if (is_at_sphere_offset_ && !proxy_.is_free) swept_.keep_only(sphere_.offset());
  const bool has_settled = swept_.descend(proxy_, device, std::max(work_left_, kMinSweptWork));
  work_left_ -= swept_.work();
  return has_settled;
}

// True if the step was finished on the surface and in free space. Otherwise the proxy is on the surface, or free, for the device position
// at `time`.
bool ProxyMethod::follow_surface(const Vec3& last, const Vec3& device, double& time) noexcept {
  using Outcome = SurfaceFollower::Outcome;
  using Met = FreeFlight::Met;
  if (is_far(last) || is_far(device)) return false;
  Outcome outcome = Outcome::settled;
  bool has_settled = !is_unconverged_;
  is_unconverged_ = false;
  for (int leg = 0; leg < kMaxLegs && work_left_ > 0; ++leg) {
    const Vec3 here = on_path(last, device, time);
    if (!surface_.is_on_surface()) {
      const Met met = fly_to_device(here, device, time);
      if (met != Met::walkable) {
        proxy_.settle_at(met == Met::nothing ? device : here);
        return met == Met::nothing;
      }
      has_settled = true;
    }
    outcome = has_settled ? surface_.follow(last, device, time, work_left_) : surface_.descend(here, work_left_);
    work_left_ = surface_.work_left();
    if (outcome == Outcome::unwalkable) return false;
    if (outcome == Outcome::exhausted) {
      carry(on_path(last, device, time));
      is_unconverged_ = true;
    }
    if (outcome == Outcome::exhausted || (outcome == Outcome::settled && time >= 1.0)) {
      hold_by_surface(device);
      return true;
    }
    has_settled = true;
    if (outcome == Outcome::settled) continue;
    ++counters_.flights;
    if (outcome == Outcome::released) {
      const Met met = fly_to_device(surface_.at().lifted_towards(device, kFlightStartHeight), device, time);
      if (met == Met::walkable) continue;
      if (met == Met::other) return false;
      surface_.leave();
      proxy_.settle_at(device);
      return true;
    }
    double until = 1.0;
    const Vec3 at = on_path(last, device, time);
    const Met met = flight_.fly(surface_.at().lifted_towards(at, kFlightStartHeight), at, surface_.slides(), surface_, until);
    work_left_ -= flight_.work();
    if (met == Met::other) return false;
    if (met == Met::nothing) {
      surface_.leave();
      proxy_.settle_at(at);
    }
    has_settled = met == Met::nothing;
  }
  is_unconverged_ = surface_.is_on_surface();
  if (!is_unconverged_) return false;
  carry(on_path(last, device, time));
  hold_by_surface(device);
  return true;
}

// Flies straight, while the device goes to its end: if the flight meets a walkable triangle, `time` becomes the time of the contact.
FreeFlight::Met ProxyMethod::fly_to_device(const Vec3& from, const Vec3& device, double& time) noexcept {
  double until = 1.0;
  const FreeFlight::Met met = flight_.fly(from, device, false, surface_, until);
  work_left_ -= flight_.work();
  if (met == FreeFlight::Met::walkable) time = std::min(1.0, time + (1.0 - time) * until);
  return met;
}

// The rest of the motion, from the position `device` on, follows in the next step.
void ProxyMethod::carry(const Vec3& device) noexcept {
  ++counters_.exhausted;
  carried_from_ = device;
}

void ProxyMethod::move_start_off_surfaces() noexcept {
  proxy_.position = flight_.clear_of_surfaces(proxy_.position, kEdgeReach * kContactOffset);
}

// Sets the state at the end of a step in which the surface holds the proxy.
void ProxyMethod::hold_by_surface(const Vec3& device) noexcept {
  proxy_.position = surface_.lifted(kContactOffset);
  is_at_sphere_offset_ = false;
  active_offset_ = kContactOffset;
  proxy_.is_free = false;
  proxy_.slides = surface_.slides();
  std::array<SurfacePoint::Contact, 3> contacts;
  proxy_.active_count = shading_ > 0.0 ? surface_.at().find_contacts(device, contacts) : 0;
  proxy_.contact_count = std::max(proxy_.active_count, 1);
  proxy_.contacts[0].triangle = surface_.at().a().id;
  for (int i = 0; i < proxy_.active_count; ++i) {
    proxy_.contacts[i].triangle = contacts[i].triangle;
    proxy_.contacts[i].separation = {0.0, contacts[i].normal, proxy_.position, Feature::face};
    proxy_.multipliers[i] = contacts[i].multiplier;
  }
}

// Whether a triangle is nearer to p than `distance`.
bool ProxyMethod::is_nearer_to_surface(const Vec3& p, double distance) const noexcept {
  bool any = false;
  geometry_.for_each_overlapping(Box{p, p}.inflated(distance), [&](std::uint32_t id) {
    any = any || geometry_.separation(id, p).distance < distance;
    return !any;
  });
  return any;
}

// Lifts the proxy to the distance that sweeps keep, and away from every edge, so that nothing beyond an edge is nearer. If the triangle is
// too narrow for that and the faces beside it are nearer, lifts above these as well. In the wedge between two faces, lifts at a place
// farther from the tip of the wedge, where the other face is not in the way.
void ProxyMethod::lift_off_surface() noexcept {
  // From 512 contact offsets (kEdgeReach) in five tries to 2^21 of them, 2^-9 of the scene.
  constexpr double kFarther = 8.0;
  constexpr int kMaxTries = 5;
  const SurfacePoint::Facet face = surface_.at().a();
  const Vec3 normal = face.normal();
  const auto is_in_the_way = [&](const Vec3& p, const Vec3& to) {
    bool any = false;
    geometry_.for_each_overlapping(Box::around(p, to), [&](std::uint32_t id) {
      any = any || (id != face.id && geometry_.pierce(id, p, to).time <= 1.0 && surfaces_.can_touch(id, p));
    });
    return any;
  };
  double beside = kEdgeReach * kContactOffset;
  Vec3 from;
  Vec3 lifted;
  for (int i = 0; i < kMaxTries; ++i, beside *= kFarther) {
    from = surface_.at().inside(beside);
    double room = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) room = std::min(room, face.shape.inside(k, from) / face.shape.length(k));
    lifted = from + clearance_.offset * normal;
    if (room < kNarrow * kContactOffset && is_nearer_to_surface(lifted, 0.5 * clearance_.offset))
      lifted = surface_.at().lifted(clearance_.offset);
    if (!is_in_the_way(from, lifted)) break;
  }
  is_at_sphere_offset_ = false;
  const bool slides = surface_.slides();
  tries_.lifted = {surface_.point(), (lifted - surface_.point()).norm()};
  surface_.leave();
  sphere_.stop_tracking();
  sphere_.forget_near();
  proxy_.settle_at(lifted);
  proxy_.is_free = false;
  proxy_.slides = slides;
  ProxyContact& contact = proxy_.contacts[proxy_.contact_count++];
  contact = {face.id, face.shape, {clearance_.offset, normal, from, Feature::face}};
}

// Puts a proxy that sweeps have settled on walkable faces back onto the surface. Not near where it was lifted off before this motion ran
// out of work: it would be lifted off again, and that may leave no work to get farther.
bool ProxyMethod::land_on_surface() noexcept {
  if (tries_.lifted && (proxy_.position - tries_.lifted->from).norm() <= 2.0 * tries_.lifted->distance) return false;
  const auto active = proxy_.active();
  if (active.empty() || active.size() > 2) return false;
  for (const ProxyContact& contact : active) {
    if (contact.separation.feature != Feature::face || !geometry_.is_walkable(contact.triangle)) return false;
  }
  const std::uint32_t triangle = active[0].triangle;
  const ContactTriangle shape = surfaces_.shape_of(triangle);
  const bool back = shape.normal().dot(active[0].separation.normal) < 0.0;
  const Vec3 p = proxy_.position - shape.normal().dot(proxy_.position - shape.corner(0)) * shape.normal();
  if (active.size() == 1) {
    for (int k = 0; k < 3; ++k) {
      if (!(shape.inside(k, p) > 0.0)) return false;
    }
    is_unconverged_ = surface_.land(triangle, back, p, proxy_.slides);
    return is_unconverged_;
  }
  for (int k = 0; k < 3; ++k) {
    const TouchGeometry::Adjacent adjacent = geometry_.adjacent(triangle, k);
    if (!adjacent.exists || adjacent.id != active[1].triangle) continue;
    const double along = shape.along(k, p);
    const Vec3 on_edge = shape.corner(k) + along * shape.edge(k);
    if (!(along > 0.0 && along < 1.0) || (on_edge - p).norm() > kEdgeReach * kContactOffset) return false;
    is_unconverged_ = surface_.land_on_edge(triangle, back, k, on_edge, proxy_.slides);
    return is_unconverged_;
  }
  return false;
}

}  // namespace hapton
