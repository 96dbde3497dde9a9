#include "core/force/proxy/surface_friction.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/force/sliding_friction.h"
#include "core/math/quadratic.h"

namespace hapton {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();
// A pull within this share of the cone's radius is on the cone: 4,096 times the rounding of a pull.
constexpr double kOnCone = 0x1p-40;
constexpr double kMinPull = SurfacePoint::kMinPull;  // a shorter pull is mostly rounding
constexpr int kMaxHalvings = 96;                     // limits the rounds; Newton's method needs only a few

constexpr auto kOnEdge = SurfacePoint::kOnEdge;
constexpr auto kClear = SurfacePoint::kClear;
constexpr auto kSnap = SurfacePoint::kSnap;
using On = SurfacePoint::On;

SurfaceNext again_if(bool walkable) { return walkable ? SurfaceNext::again : SurfaceNext::unwalkable; }
SurfaceNext descend_if(bool walkable) { return walkable ? SurfaceNext::descend : SurfaceNext::unwalkable; }

// The pull on a point at rest by a device that moves straight: start + t motion.
struct MovingPull {
  Vec3 start, motion;

  Vec3 at(double t) const { return start + t * motion; }
  // The time at which of_square |pull|^2 + of_height (normal . pull)^2 - bound, a polynomial in t, rises above zero.
  double time_of_rise(double of_square, const Vec3& normal, double of_height, double bound = 0.0) const {
    const double height = normal.dot(start);
    const double climb = normal.dot(motion);
    return hapton::time_of_rise(of_square * motion.squaredNorm() + of_height * climb * climb,
                                of_square * motion.dot(start) + of_height * climb * height,
                                of_square * start.squaredNorm() + of_height * height * height - bound);
  }
};

// The zero of a function that falls from >= 0 at `low` to <= 0 at `high`, to the last digit that it resolves. `value` also returns the
// slope, or 0. Newton's method, with bisection where it leaves the interval.
template <class Value>
double find_fall(double low, double high, Value&& value) {
  double t = low;
  for (int i = 0; i < kMaxHalvings && low < high; ++i) {
    double slope = 0.0;
    const double f = value(t, slope);
    if (f == 0.0) return t;
    (f > 0.0 ? low : high) = t;
    double next = slope < 0.0 ? t - f / slope : kNever;
    if (!(next > low && next < high)) {
      if (next == t) return t;
      next = 0.5 * (low + high);
    }
    if (next == t || std::fabs(next - t) <= 0x1p-52 * t) return next;
    t = next;
  }
  return t;
}

// Searches for the first moment, as a share of the remaining step, at which the pull on a point at rest exceeds its cone.
struct SlipSearch {
  MovingPull pull;
  double mu;                // the coefficient of friction that holds the point
  double min_pull_squared;  // square of the shortest pull that counts
  double soonest = kNever;

  // Considers a slip over a face. It counts only if the pull at that moment leads onto the face: is_over(pull).
  template <class IsOver>
  void consider_face(const Vec3& normal, IsOver&& is_over) {
    const double t = pull.time_of_rise(1.0, normal, -(1.0 + mu * mu), min_pull_squared);
    if (t < soonest && is_over(pull.at(t))) soonest = t;
  }
  void consider_line(const Vec3& direction, bool both_ways) {
    const double t = pull.time_of_rise(-mu * mu, direction, 1.0 + mu * mu, min_pull_squared);
    if (t < soonest && (both_ways || direction.dot(pull.at(t)) > 0.0)) soonest = t;
  }
};

// Considers all slips from an edge: onto one of its faces, or along the edge.
void search_from_edge(const SurfacePoint& at, SlipSearch& slip) {
  const auto is_over = [&](const SurfacePoint::Facet& facet, int k) {
    return [&facet, k](const Vec3& w) {
      return facet.normal().dot(w) <= kClear && facet.shape.inside(k, facet.shape.corner(k) + w) > kOnEdge * facet.shape.length(k);
    };
  };
  if (!at.has_left_a()) slip.consider_face(at.a().normal(), is_over(at.a(), at.edge()));
  slip.consider_face(at.b().normal(), is_over(at.b(), at.other_edge()));
  slip.consider_line(at.a().shape.edge(at.edge()) / at.a().shape.length(at.edge()), true);
}

// Considers all slips from a vertex: onto a face of its fan, or along an edge of the fan.
void search_from_vertex(const SurfacePoint& at, SlipSearch& slip) {
  for (const SurfacePoint::FanFacet& facet : at.fan()) {
    slip.consider_face(facet.normal, [&](const Vec3& w) { return facet.inward[0].dot(w) > 0.0 && facet.inward[1].dot(w) > 0.0; });
    slip.consider_line(facet.direction, false);
  }
}

// The edge of a face that a sliding point crosses first, and when, as a share of the remaining step. edge -1: none.
struct CrossedEdge {
  int edge = -1;
  double time = kNever;
};

// `point` gives the position of the point at a share of the remaining step; `leave_time` is the share at which the search ends.
template <class Point>
CrossedEdge find_crossed_edge(const SurfacePoint::Facet& facet, const SlidingPull& sliding, double leave_time, Point&& point) {
  CrossedEdge first;
  const Vec3 normal = facet.normal();
  for (int k = 0; k < 3; ++k) {
    const Vec3 inward = normal.cross(facet.shape.edge(k)) * facet.side;
    // The point crosses an edge at most once: its speed across the edge changes sign at most once, where inward . pull does.
    const double turn = std::min(leave_time, sliding.time_across(inward));
    const bool falls = inward.dot(sliding.at(0.5 * turn)) < 0.0;
    double low = falls ? 0.0 : turn;
    const double high = falls ? turn : leave_time;
    const auto inside = [&](double t) { return SurfacePoint::inside_by(-kOnEdge, facet, k, point(t)); };
    if (!(inside(high) <= 0.0)) continue;
    if (inside(low) > 0.0) {
      low = find_fall(low, high, [&](double t, double& slope) {
        const Vec3 behind = sliding.at(t);
        const double length = behind.norm();
        slope = length > 0.0 ? inward.dot(behind) / length * sliding.speed_at(t) : 0.0;
        return inside(t);
      });
    }
    if (low < first.time) first = {.edge = k, .time = low};
  }
  return first;
}

// A point that slides along an edge behind a device that moves straight, at x = device - sign mu_d depth. t: share of the remaining step.
struct EdgeSlide {
  EdgeSlide(const SurfacePoint& at, const Vec3& from, const Vec3& to, double time, double mu) : dynamic(mu) {
    const ContactTriangle& face = at.a().shape;
    const int edge = at.edge();
    direction = face.edge(edge) / face.length(edge);
    here = on_path(from, to, time) - face.corner(edge);
    motion = (1.0 - time) * (to - from);
    const double pull = direction.dot(here - (at.point() - face.corner(edge)));
    sign = (std::fabs(pull) > kMinPull ? pull : direction.dot(motion)) < 0.0 ? -1.0 : 1.0;
    sideways = here - direction.dot(here) * direction;
    sideways_motion = motion - direction.dot(motion) * direction;
    device_travel = sign * direction.dot(motion);
  }

  Vec3 direction;                  // of the edge, a unit vector
  Vec3 here, motion;               // the device's position from the edge's first corner, and its motion in the remaining step
  Vec3 sideways, sideways_motion;  // the parts of these perpendicular to the edge
  double sign;                     // 1: along `direction`; -1: against it
  double device_travel;            // motion of the device along the edge, in the direction of the slide
  double dynamic;                  // mu_d

  double depth(double t) const { return (sideways + t * sideways_motion).norm(); }
  // Speed along the edge. It falls with time because the depth is convex.
  double speed(double t) const {
    const double d = depth(t);
    return device_travel - dynamic * (d > 0.0 ? (sideways + t * sideways_motion).dot(sideways_motion) / d : 0.0);
  }
  double x(double t) const { return direction.dot(here) + t * direction.dot(motion) - sign * dynamic * depth(t); }
};

}  // namespace

void SurfaceFriction::begin(const Material& material, bool slides) noexcept {
  static_mu_ = material.friction_static;
  dynamic_mu_ = std::min(material.friction_dynamic, material.friction_static);
  slides_ = slides && acts();
  drags_ = false;
  slips_ = false;
}

// Whether a pull moves the point: the pull exceeds the cone, or the current event is that it leaves the cone.
bool SurfaceFriction::moves(double pull_length, double depth) const noexcept {
  if (slips_) return true;
  const double cone = (slides_ ? dynamic_mu_ : static_mu_) * (1.0 + kOnCone) * depth;
  return pull_length * pull_length > cone * cone + kMinPull * kMinPull;
}

// The pull is within the cone and the point stays. If the pull is on the cone, a moving device drags the point.
SurfaceNext SurfaceFriction::hold(double pull_length, double depth) noexcept {
  drags_ = slides_ && pull_length >= dynamic_mu_ * (1.0 - kOnCone) * depth - kMinPull;
  slides_ = slides_ && pull_length >= FrictionMotion::kRestick * dynamic_mu_ * depth;
  return SurfaceNext::settled;
}

// The share of the pull by which the point moves until the pull is on the dynamic cone.
double SurfaceFriction::begin_slide(double pull_length, double depth) noexcept {
  slides_ = true;
  drags_ = true;
  slips_ = false;
  return pull_length > 0.0 ? std::clamp(1.0 - dynamic_mu_ * depth / pull_length, 0.0, 1.0) : 0.0;
}

SurfaceNext SurfaceFriction::descend(SurfacePoint& at, const Vec3& device) noexcept {
  const SurfaceNext next = at.on() == On::face   ? descend_on_face(at, device)
                           : at.on() == On::edge ? descend_on_edge(at, device)
                                                 : descend_at_vertex(at, device);
  if (next != SurfaceNext::again) slips_ = false;
  return next;
}

SurfaceNext SurfaceFriction::descend_on_face(SurfacePoint& at, const Vec3& device) noexcept {
  const double height = at.a().height(device);
  if (height > kClear) return SurfaceNext::airborne;
  const Vec3 pull = device - height * at.a().normal() - at.point();
  const double pull_length = pull.norm();
  const double depth = std::max(0.0, -height);
  if (!moves(pull_length, depth)) return hold(pull_length, depth);
  const Vec3 goal = at.point() + begin_slide(pull_length, depth) * pull;
  const SurfacePoint::Exit exit = at.find_exit(goal);
  if (exit.edge >= 0) return again_if(at.reach_edge(exit.edge, at.point() + exit.time * (goal - at.point())));
  at.move_on_face(goal);
  return SurfaceNext::settled;
}

SurfaceNext SurfaceFriction::descend_on_edge(SurfacePoint& at, const Vec3& device) noexcept {
  if (at.is_free_over_edge(device)) return SurfaceNext::airborne;
  const Vec3 pull = device - at.point();
  if (const SurfacePoint::Facet* over = at.find_over_edge(device)) {
    const double height = over->height(device);
    const double pull_length = std::sqrt(std::max(0.0, pull.squaredNorm() - height * height));
    const double depth = std::max(0.0, -height);
    if (!moves(pull_length, depth)) {
      at.balance_on_edge();
      hold(pull_length, depth);
      drags_ = false;  // the pull leads onto a face: no drag along the edge
      return SurfaceNext::settled;
    }
    at.leave_edge(*over);
    return SurfaceNext::again;
  }
  const ContactTriangle& face = at.a().shape;
  const int edge = at.edge();
  const double length = face.length(edge);
  const double pull_along = face.edge(edge).dot(pull) / length;
  const double depth = (pull - (pull_along / length) * face.edge(edge)).norm();
  if (!moves(std::fabs(pull_along), depth)) {
    at.balance_on_edge();
    return hold(std::fabs(pull_along), depth);
  }
  const double goal = face.along(edge, at.point()) + begin_slide(std::fabs(pull_along), depth) * pull_along / length;
  if (pull_along < 0.0 && goal * length <= kSnap) return again_if(at.reach_vertex(edge));
  if (pull_along > 0.0 && (1.0 - goal) * length <= kSnap) return again_if(at.reach_vertex((edge + 1) % 3));
  at.move_on_edge(std::clamp(goal, 0.0, 1.0));
  at.balance_on_edge();
  return SurfaceNext::settled;
}

SurfaceNext SurfaceFriction::descend_at_vertex(SurfacePoint& at, const Vec3& device) noexcept {
  const Vec3 pull = device - at.point();
  const SurfacePoint::Descent descent = at.find_steepest(pull, at.least_slope(device));
  if (descent.facet == nullptr ? at.is_free_at_vertex(pull) : at.is_free_along(descent, pull)) return SurfaceNext::airborne;
  const double depth = std::sqrt(std::max(0.0, pull.squaredNorm() - descent.length * descent.length));
  if (descent.facet == nullptr || !moves(descent.length, depth)) {
    hold(descent.facet == nullptr ? 0.0 : descent.length, depth);
    drags_ = false;
    return SurfaceNext::settled;
  }
  slides_ = true;
  return at.descend_along(descent, device);
}

SurfaceNext SurfaceFriction::follow(SurfacePoint& at, const Vec3& from, const Vec3& to, double& time) noexcept {
  if (!drags_ || at.on() == On::vertex) return stay(at, from, to, time);
  return at.on() == On::face ? slide_on_face(at, from, to, time) : slide_on_edge(at, from, to, time);
}

// The point stays until the pull exceeds the cone on some face or edge.
SurfaceNext SurfaceFriction::stay(SurfacePoint& at, const Vec3& from, const Vec3& to, double& time) noexcept {
  drags_ = false;
  const MovingPull pull{on_path(from, to, time) - at.point(), (1.0 - time) * (to - from)};
  // At a vertex, twice the least descent, so that the descent accepts what is found here.
  const double least = at.on() == On::vertex ? 2.0 * std::max(at.least_slope(from), at.least_slope(to)) : kMinPull;
  SlipSearch slip{.pull = pull, .mu = slides_ ? dynamic_mu_ : static_mu_, .min_pull_squared = least * least};
  if (at.on() == On::face) {
    slip.consider_face(at.a().normal(), [](const Vec3&) { return true; });
    if (slides_) {
      const double restick_mu = FrictionMotion::kRestick * dynamic_mu_;
      const double t = pull.time_of_rise(-1.0, at.a().normal(), 1.0 + restick_mu * restick_mu);
      if (t < slip.soonest && t < 1.0) {
        slides_ = false;
        time = std::min(1.0, time + t * (1.0 - time));
        return SurfaceNext::again;
      }
    }
    // The device may also come to the front of the face, exactly through the point.
    const double height = at.a().normal().dot(pull.start) - kClear;
    const double there = at.a().normal().dot(pull.at(1.0)) - kClear;
    const double release_time = there > 0.0 ? time_of_zero(std::min(height, 0.0), there, 0.0) : kNever;
    if (release_time <= std::min(slip.soonest, 1.0)) {
      time = std::min(1.0, time + release_time * (1.0 - time));
      return at.release(on_path(from, to, time), to);
    }
  } else if (at.on() == On::edge) {
    search_from_edge(at, slip);
  } else {
    search_from_vertex(at, slip);
  }
  if (slip.soonest > 1.0) {
    time = 1.0;
    if (at.on() == On::face) return SurfaceNext::settled;
    const SurfaceNext next = at.on() == On::edge ? descend_on_edge(at, to) : descend_at_vertex(at, to);  // the point may be free at `to`
    return next == SurfaceNext::again ? SurfaceNext::descend : next;
  }
  time = std::min(1.0, time + slip.soonest * (1.0 - time));
  at.balance_on_edge();
  slips_ = true;
  return SurfaceNext::descend;
}

SurfaceNext SurfaceFriction::slide_on_face(SurfacePoint& at, const Vec3& from, const Vec3& to, double& time) noexcept {
  const Vec3 here = on_path(from, to, time);
  const Vec3 normal = at.a().normal();
  const double start_height = std::min(at.a().height(here), 0.0);
  const double end_height = at.a().height(to);
  const auto projection = [&](double t) {  // t: share of the remaining step, here and below
    const Vec3 device = t < 1.0 ? Vec3(here + t * (to - here)) : to;
    return Vec3(device - at.a().height(device) * normal);
  };
  const auto in_plane = [&](const Vec3& v) { return Vec3(v - normal.dot(v) * normal); };
  const Vec3 motion = in_plane(projection(1.0) - projection(0.0));
  const Vec3 pull = in_plane(projection(0.0) - at.point());
  const double radius = -dynamic_mu_ * start_height;
  const double growth = -dynamic_mu_ * (end_height - start_height);
  const bool has_pull = radius > 0.0 && pull.norm() > kMinPull;  // a shorter pull has no direction
  // A device at rest, or a cone that grows faster than the pull, stops the point.
  if (has_pull ? !(pull.dot(motion) > pull.norm() * growth) : motion.isZero(0.0)) {
    drags_ = false;
    return SurfaceNext::again;
  }
  const SlidingPull sliding(has_pull ? pull : motion, motion, has_pull ? radius : std::numeric_limits<double>::min(), growth);
  const auto point = [&](double t) { return Vec3(projection(t) - sliding.at(t)); };
  const double leave_time = end_height > kClear ? time_of_zero(start_height - kClear, end_height - kClear, 0.0) : 1.0;
  const CrossedEdge crossed = find_crossed_edge(at.a(), sliding, leave_time, point);
  if (crossed.edge < 0 || crossed.time > leave_time) {
    time = std::min(1.0, time + leave_time * (1.0 - time));
    if (end_height > kClear) return at.release(on_path(from, to, time), to);
    at.move_on_face(point(1.0));
    return SurfaceNext::settled;
  }
  const bool turns_back = crossed.edge == at.entry_edge() && crossed.time <= 0.0;
  const Vec3 p = point(crossed.time);
  time = std::min(1.0, time + crossed.time * (1.0 - time));
  if (!at.reach_edge(crossed.edge, p)) return SurfaceNext::unwalkable;
  if (turns_back && at.on() == On::edge) {
    // The adjacent face sent the point back: both decisions are due to rounding.
    at.balance_on_edge();
    drags_ = false;
    return SurfaceNext::again;
  }
  return SurfaceNext::descend;
}

// Slides along an edge, at x = device - sign mu_d depth, until the device leads onto a face, the point stops, or the edge ends.
SurfaceNext SurfaceFriction::slide_on_edge(SurfacePoint& at, const Vec3& from, const Vec3& to, double& time) noexcept {
  const int edge = at.edge();
  const double length = at.a().shape.length(edge);
  const EdgeSlide slide(at, from, to, time, dynamic_mu_);
  if (!(slide.speed(0.0) > 0.0)) {
    drags_ = false;
    return SurfaceNext::again;
  }
  const bool stops = !(slide.speed(1.0) > 0.0);
  double until = !stops ? 1.0 : find_fall(0.0, 1.0, [&](double t, double& slope) {
    slope = 0.0;
    return slide.speed(t);
  });
  // The point leaves onto a face when the multiplier of the other face has reached zero.
  enum class Event : std::uint8_t { none, to_a, to_b, end } event = Event::none;
  const Vec3 device = on_path(from, to, time);
  const auto consider_face = [&](const SurfacePoint::Facet& facet, int k, Event which) {
    const double there = SurfacePoint::inside_by(kOnEdge, facet, k, to);
    if (!(there > 0.0)) return;
    const double t = time_of_zero(std::min(SurfacePoint::inside_by(kOnEdge, facet, k, device), 0.0), there, 0.0);
    if (t < until) {
      until = t;
      event = which;
    }
  };
  consider_face(at.a(), edge, Event::to_a);
  consider_face(at.b(), at.other_edge(), Event::to_b);
  const double end = slide.sign > 0.0 ? length : 0.0;
  if (slide.sign * (end - slide.x(until)) <= 0.0) {
    until = find_fall(0.0, until, [&](double t, double& slope) {
      slope = -slide.speed(t);
      return slide.sign * (end - slide.x(t));
    });
    event = Event::end;
  }
  time = std::min(1.0, time + until * (1.0 - time));
  if (event == Event::end) return descend_if(at.reach_vertex(slide.sign > 0.0 ? (edge + 1) % 3 : edge));
  at.move_on_edge(std::clamp(slide.x(until) / length, 0.0, 1.0));
  at.balance_on_edge();
  if (event == Event::to_b) at.cross_edge();
  if (event == Event::to_a) at.return_from_edge();
  if (event != Event::none) return SurfaceNext::again;
  if (stops) {
    drags_ = false;
    return SurfaceNext::again;
  }
  return at.is_free_over_edge(to) ? SurfaceNext::airborne : SurfaceNext::settled;
}

}  // namespace hapton
