#include "core/force/proxy/surface_follower.h"

#include <algorithm>
#include <cmath>

namespace hapton {
namespace {

constexpr auto kOnEdge = SurfacePoint::kOnEdge;
constexpr auto kClear = SurfacePoint::kClear;
constexpr auto kSnap = SurfacePoint::kSnap;
using On = SurfacePoint::On;

SurfaceNext again_if(bool walkable) { return walkable ? SurfaceNext::again : SurfaceNext::unwalkable; }

}  // namespace

bool SurfaceFollower::land(std::uint32_t triangle, bool back, const Vec3& p, bool slides) noexcept {
  if (!at_.land(triangle, back, p)) return false;
  friction_.begin(at_.material(), slides);
  return true;
}

bool SurfaceFollower::land_on_edge(std::uint32_t triangle, bool back, int k, const Vec3& p, bool slides) noexcept {
  if (!at_.land_on_edge(triangle, back, k, p)) return false;
  friction_.begin(at_.material(), slides);
  return true;
}

// An event at a vertex costs more with more facets; with friction every event costs twice as much.
void SurfaceFollower::spend() noexcept {
  const int units = 1 + (at_.on() == On::vertex ? static_cast<int>(at_.fan().size()) / kFacetsPerUnit : 0);
  work_left_ -= friction_.acts() ? 2 * units : units;
}

SurfaceFollower::Outcome SurfaceFollower::descend(const Vec3& device, int most_work) noexcept {
  for (work_left_ = most_work; work_left_ > 0; spend()) {
    ++events_;
    const Next next = next_descent(device);
    if (next != Next::again) return next;
  }
  return Outcome::exhausted;
}

SurfaceFollower::Outcome SurfaceFollower::follow(const Vec3& from, const Vec3& to, double& time, int most_work) noexcept {
  for (work_left_ = most_work; work_left_ > 0; spend()) {
    ++events_;
    const Next next = next_event(from, to, time);
    if (next == Next::again) continue;
    if (next != Next::descend) return next;
    const Outcome outcome = descend(on_path(from, to, time), work_left_);
    if (outcome != Outcome::settled) return outcome;
  }
  return Outcome::exhausted;
}

SurfaceFollower::Next SurfaceFollower::next_descent(const Vec3& device) noexcept {
  if (friction_.acts()) return friction_.descend(at_, device);
  return at_.on() == On::face ? descend_on_face(device) : at_.on() == On::edge ? descend_on_edge(device) : descend_at_vertex(device);
}

SurfaceFollower::Next SurfaceFollower::next_event(const Vec3& from, const Vec3& to, double& time) noexcept {
  if (friction_.acts()) return friction_.follow(at_, from, to, time);
  return at_.on() == On::face   ? follow_on_face(from, to, time)
         : at_.on() == On::edge ? follow_on_edge(from, to, time)
                                : follow_at_vertex(from, to, time);
}

// Moves the point to the projection of the device onto the face, or to the first edge on the path to it.
SurfaceFollower::Next SurfaceFollower::descend_on_face(const Vec3& device) noexcept {
  const double height = at_.a().height(device);
  if (height > kClear) return Next::airborne;
  const Vec3 goal = device - height * at_.a().normal();
  const SurfacePoint::Exit exit = at_.find_exit(goal);
  if (exit.edge < 0) return settle_on_face(goal, device);
  return again_if(at_.reach_edge(exit.edge, at_.point() + exit.time * (goal - at_.point())));
}

// Settles on a face. If the point balances on a convex edge with the device beyond it, it crosses to the adjacent face instead, or is free.
SurfaceFollower::Next SurfaceFollower::settle_on_face(const Vec3& p, const Vec3& device) noexcept {
  at_.move_on_face(p);
  for (int k = 0; k < 3; ++k) {
    if (!(SurfacePoint::inside_by(kBalance, at_.a(), k, p) < 0.0)) continue;
    if (!at_.load_adjacent(k) || !at_.is_convex()) continue;
    const bool is_free = at_.b().height(device) > kClear;
    if (!is_free && !(SurfacePoint::inside_by(4.0 * kBalance, at_.b(), at_.other_edge(), device) > 0.0)) continue;
    at_.move_on_edge(std::clamp(at_.a().shape.along(k, p), 0.0, 1.0));
    if (is_free) return Next::airborne;
    at_.cross_edge();
    return Next::again;
  }
  return Next::settled;
}

// Moves onto the face that leads nearer to the device; if neither face does, the edge is concave and the point moves along it.
SurfaceFollower::Next SurfaceFollower::descend_on_edge(const Vec3& device) noexcept {
  if (at_.is_free_over_edge(device)) return Next::airborne;
  if (const SurfacePoint::Facet* over = at_.find_over_edge(device)) {
    at_.leave_edge(*over);
    return Next::again;
  }
  const ContactTriangle& face = at_.a().shape;
  const double along = face.along(at_.edge(), device);
  const double length = face.length(at_.edge());
  if (along * length <= kSnap) return again_if(at_.reach_vertex(at_.edge()));
  if ((1.0 - along) * length <= kSnap) return again_if(at_.reach_vertex((at_.edge() + 1) % 3));
  return settle_on_edge(along, device);
}

// Settles on a concave edge. If the point balances at an end of the edge with the device beyond that end, it moves over the vertex at the
// end instead, or is free.
SurfaceFollower::Next SurfaceFollower::settle_on_edge(double along, const Vec3& device) noexcept {
  at_.move_on_edge(along);
  at_.balance_on_edge();
  return is_near_end_of_edge() ? go_over_end(device) : Next::settled;
}

bool SurfaceFollower::is_near_end_of_edge() const noexcept {
  const ContactTriangle& face = at_.a().shape;
  const double along = face.along(at_.edge(), at_.point());
  return std::min(along, 1.0 - along) * face.length(at_.edge()) < kBalance;
}

// The point stays if the vertex leads only back to the edge or its faces. Pre: is_near_end_of_edge().
SurfaceFollower::Next SurfaceFollower::go_over_end(const Vec3& device) noexcept {
  const SurfacePoint::Facet face = at_.a();
  const int edge = at_.edge();
  const Vec3 p = at_.point();
  const int end = face.shape.along(edge, p) < 0.5 ? edge : (edge + 1) % 3;
  if (at_.reach_vertex(end)) {
    const Vec3 to_device = device - at_.point();
    const SurfacePoint::Descent descent = at_.find_steepest(to_device, at_.least_slope(device));
    if (descent.facet == nullptr && at_.is_free_at_vertex(to_device)) return Next::airborne;
    if (descent.facet != nullptr && descent.length > 4.0 * kBalance) return at_.descend_along(descent, device);
  }
  return at_.land_on_edge(face.id, face.is_back(), edge, p) ? Next::settled : Next::unwalkable;
}

// Moves in the steepest direction: over that face or edge at the vertex which comes nearest to the device.
SurfaceFollower::Next SurfaceFollower::descend_at_vertex(const Vec3& device) noexcept {
  const Vec3 to_device = device - at_.point();
  const SurfacePoint::Descent descent = at_.find_steepest(to_device, at_.least_slope(device));
  if (descent.facet == nullptr) return at_.is_free_at_vertex(to_device) ? Next::airborne : Next::settled;
  return at_.descend_along(descent, device);
}

SurfaceFollower::Next SurfaceFollower::follow_on_face(const Vec3& from, const Vec3& to, double& time) noexcept {
  const double height = at_.a().height(to);
  double soonest = 2.0;
  int exit = -1;
  for (int k = 0; k < 3; ++k) {
    const double there = SurfacePoint::inside_by(-kOnEdge, at_.a(), k, to);
    if (there > 0.0) continue;
    const double t = time_of_zero(std::max(SurfacePoint::inside_by(-kOnEdge, at_.a(), k, from), 0.0), there, time);
    if (t < soonest) {
      soonest = t;
      exit = k;
    }
  }
  if (height > kClear) {
    const double t = time_of_zero(std::min(at_.a().height(from) - kClear, 0.0), height - kClear, time);
    if (t <= soonest) {
      time = t;
      return at_.release(on_path(from, to, t), to);
    }
  }
  if (exit < 0) {
    time = 1.0;
    const Next next = settle_on_face(to - height * at_.a().normal(), to);
    return next == Next::again ? Next::descend : next;
  }
  // The point leaves over the edge by which it just entered, because the other face sent it back. Both decisions are due to rounding, so
  // the edge holds the point.
  const bool turns_back = exit == at_.entry_edge() && soonest <= time;
  time = soonest;
  const Vec3 device = on_path(from, to, time);
  if (!at_.reach_edge(exit, device - at_.a().height(device) * at_.a().normal())) return Next::unwalkable;
  if (!turns_back || at_.on() != On::edge) return Next::descend;
  at_.balance_on_edge();
  return Next::again;
}

SurfaceFollower::Next SurfaceFollower::follow_on_edge(const Vec3& from, const Vec3& to, double& time) noexcept {
  const ContactTriangle& face = at_.a().shape;
  const int edge = at_.edge();
  const bool has_moved = time < 1.0;  // the device has moved since the last descent
  double soonest = 2.0;
  enum class Event : std::uint8_t { none, to_a, to_b, begin, end } event = Event::none;
  const auto consider = [&](double at_0, double at_1, Event which) {
    const double t = time_of_zero(at_0, at_1, time);
    if (t < soonest) {
      soonest = t;
      event = which;
    }
  };
  const auto consider_face = [&](const SurfacePoint::Facet& facet, int k, Event which) {
    const double there = SurfacePoint::inside_by(kOnEdge, facet, k, to);
    if (there > 0.0) consider(std::min(SurfacePoint::inside_by(kOnEdge, facet, k, from), 0.0), there, which);
  };
  consider_face(at_.a(), edge, Event::to_a);
  consider_face(at_.b(), at_.other_edge(), Event::to_b);
  const double along = face.along(edge, to);
  const double along_before = face.along(edge, from);
  const double near = kSnap / face.length(edge);
  if (along <= near) consider(std::max(along_before - near, 0.0), along - near, Event::begin);
  if (along >= 1.0 - near) consider(std::min(along_before - 1.0 + near, 0.0), along - 1.0 + near, Event::end);
  time = event == Event::none ? 1.0 : soonest;
  if (event == Event::begin || event == Event::end) {
    return at_.reach_vertex(event == Event::begin ? edge : (edge + 1) % 3) ? Next::descend : Next::unwalkable;
  }
  at_.move_on_edge(std::clamp(face.along(edge, on_path(from, to, time)), 0.0, 1.0));
  if (event == Event::none) {
    // Only rounding near a vertex can have put the point on an edge while the device is on the free side.
    if (at_.is_free_over_edge(to)) return Next::airborne;
    return has_moved && is_near_end_of_edge() ? Next::descend : Next::settled;
  }
  at_.leave_edge(event == Event::to_b ? at_.b() : at_.a());
  return Next::again;
}

SurfaceFollower::Next SurfaceFollower::follow_at_vertex(const Vec3& from, const Vec3& to, double& time) noexcept {
  // Twice the least descent, so that the descent accepts what is found here.
  const double least = 2.0 * std::max(at_.least_slope(from), at_.least_slope(to));
  double soonest = 2.0;
  for (const SurfacePoint::FanFacet& facet : at_.fan()) {
    const double there = facet.direction.dot(to - at_.point()) - least;
    if (!(there > 0.0)) continue;
    soonest = std::min(soonest, time_of_zero(std::min(facet.direction.dot(from - at_.point()) - least, 0.0), there, time));
  }
  if (soonest > 1.0) {
    time = 1.0;
    return at_.is_free_at_vertex(to - at_.point()) ? Next::airborne : Next::settled;
  }
  time = soonest;
  return Next::descend;
}

}  // namespace hapton
