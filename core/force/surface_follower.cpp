#include "core/force/surface_follower.h"

#include <algorithm>
#include <cmath>

#include "core/force/contact_qp.h"
#include "core/math/side_sign.h"

namespace hapton {
namespace {

Vec3 on_way(const Vec3& from, const Vec3& to, double time) { return time < 1.0 ? Vec3(from + time * (to - from)) : to; }

// When a quantity that is `at_0` at time 0 and `at_1` at time 1 passes zero, not before `now`. Pre: it does, or has.
double time_of_zero(double at_0, double at_1, double now) {
  const double t = at_0 != at_1 ? at_0 / (at_0 - at_1) : now;
  return std::clamp(t, now, 1.0);
}

}  // namespace

bool SurfaceFollower::holds(std::uint32_t triangle, bool back) const noexcept {
  return geometry_.is_walkable(triangle) && !(back && one_sided_[geometry_.mesh_of(triangle)] != 0);
}

void SurfaceFollower::load(std::uint32_t id, bool back, Facet& facet) const noexcept {
  const ObjectGeometry::Corners corners = geometry_.corners(id);
  facet.id = id;
  facet.side = back ? -1.0 : 1.0;
  facet.shape = ContactTriangle(corners.a, corners.b, corners.c);
}

bool SurfaceFollower::load_neighbour() noexcept {
  const TouchGeometry::Across across = geometry_.across(a().id, edge_);
  const bool back = a().is_back() != across.flips;
  if (!across.exists || !holds(across.id, back)) return false;
  load(across.id, back, b());
  other_edge_ = across.edge;
  return true;
}

bool SurfaceFollower::land(std::uint32_t triangle, bool back, const Vec3& p) noexcept {
  if (!holds(triangle, back)) return false;
  load(triangle, back, a());
  stands_ = true;
  stand_on_face(p);
  return true;
}

bool SurfaceFollower::land_on_edge(std::uint32_t triangle, bool back, int k, const Vec3& p) noexcept {
  if (!land(triangle, back, p)) return false;
  edge_ = k;
  if (!load_neighbour()) {
    stands_ = false;
    return false;
  }
  on_ = Stand::edge;
  has_left_a_ = false;
  return true;
}

void SurfaceFollower::stand_on_face(const Vec3& p) noexcept {
  on_ = Stand::face;
  corner_ = -1;
  came_by_ = -1;
  p_ = p;
}

void SurfaceFollower::cross_edge() noexcept {
  first_ = 1 - first_;
  stand_on_face(p_);
  came_by_ = other_edge_;
}

// As seen from the side of a(). A boundary edge is the sharpest there is.
bool SurfaceFollower::is_convex() const noexcept {
  if (a().id == b().id) return true;
  const ContactTriangle& beyond = b().shape;
  return b().side * side_sign(beyond.corner(0), beyond.corner(1), beyond.corner(2), a().shape.corner((edge_ + 2) % 3)) < 0.0;
}

// How far inside edge k the projection of the device on a facet lies, less `margin`; times the edge's length.
double SurfaceFollower::inside_by(double margin, const Facet& facet, int k, const Vec3& device) noexcept {
  return facet.shape.inside(k, device) - margin * facet.shape.length(k);
}

bool SurfaceFollower::is_free_over_edge(const Vec3& device) const noexcept {
  const bool before_a = a().height(device) > kClear;
  const bool before_b = b().height(device) > kClear;
  return before_a && before_b ? true : before_a || before_b ? is_convex() : false;
}

SurfaceFollower::Outcome SurfaceFollower::descend(const Vec3& device) noexcept {
  if (budget_ <= 0) budget_ = kMostEvents;
  for (; budget_ > 0; --budget_) {
    ++events_;
    const Next next = on_ == Stand::face   ? descend_on_face(device)
                      : on_ == Stand::edge ? descend_on_edge(device)
                                           : descend_at_vertex(device);
    if (next != Next::again) return outcome_of(next);
  }
  return Outcome::exhausted;
}

SurfaceFollower::Outcome SurfaceFollower::outcome_of(Next next) noexcept {
  switch (next) {
    case Next::settled:
      return Outcome::settled;
    case Next::airborne:
      return Outcome::airborne;
    case Next::released:
      return Outcome::released;
    default:
      return Outcome::unwalkable;
  }
}

SurfaceFollower::Outcome SurfaceFollower::follow(const Vec3& from, const Vec3& to, double& time) noexcept {
  for (budget_ = kMostEvents; budget_ > 0; --budget_) {
    ++events_;
    const Next next = on_ == Stand::face   ? follow_on_face(from, to, time)
                      : on_ == Stand::edge ? follow_on_edge(from, to, time)
                                           : follow_at_vertex(from, to, time);
    if (next == Next::again) continue;
    if (next != Next::descend) return outcome_of(next);
    const Outcome outcome = descend(on_way(from, to, time));
    if (outcome != Outcome::settled) return outcome;
  }
  return Outcome::exhausted;
}

// Straight to the projection of the device, or over the edge that is met first.
SurfaceFollower::Next SurfaceFollower::descend_on_face(const Vec3& device) noexcept {
  const ContactTriangle& face = a().shape;
  const double height = a().height(device);
  if (height > kClear) return Next::airborne;
  const Vec3 goal = device - height * a().normal();
  int exit = -1;
  double soonest = 2.0;
  for (int k = 0; k < 3; ++k) {
    if (corner_ >= 0 && k != (corner_ + 1) % 3) continue;  // the others meet where it came from
    const double there = inside_by(-kOnEdge, a(), k, device);
    if (there > 0.0) continue;
    const double here = face.inside(k, p_);
    const double t = here > 0.0 ? std::clamp(here / (here - face.inside(k, device)), 0.0, 1.0) : 0.0;
    if (t < soonest) {
      soonest = t;
      exit = k;
    }
  }
  if (exit < 0) return settle_on_face(goal, device);
  return reach_edge(exit, p_ + soonest * (goal - p_));
}

// At rest on a face, unless it balances on a convex edge and the device is beyond: over the face there, or free.
SurfaceFollower::Next SurfaceFollower::settle_on_face(const Vec3& p, const Vec3& device) noexcept {
  stand_on_face(p);
  for (int k = 0; k < 3; ++k) {
    if (!(inside_by(kBalance, a(), k, p) < 0.0)) continue;
    edge_ = k;
    if (!load_neighbour() || !is_convex()) continue;
    const bool is_free = b().height(device) > kClear;
    if (!is_free && !(inside_by(4.0 * kBalance, b(), other_edge_, device) > 0.0)) continue;
    p_ = a().shape.corner(k) + std::clamp(a().shape.along(k, p), 0.0, 1.0) * a().shape.edge(k);
    if (is_free) {
      on_ = Stand::edge;
      return Next::airborne;
    }
    cross_edge();
    return Next::again;
  }
  return Next::settled;
}

SurfaceFollower::Next SurfaceFollower::reach_edge(int k, const Vec3& p) noexcept {
  const ContactTriangle& face = a().shape;
  const double along = std::clamp(face.along(k, p), 0.0, 1.0);
  const double length_squared = face.edge(k).squaredNorm();
  if (along * along * length_squared <= kSnap * kSnap) return reach_vertex(k);
  if ((1.0 - along) * (1.0 - along) * length_squared <= kSnap * kSnap) return reach_vertex((k + 1) % 3);
  stand_on_face(face.corner(k) + along * face.edge(k));
  edge_ = k;
  if (!load_neighbour()) return Next::unwalkable;
  on_ = Stand::edge;
  has_left_a_ = true;
  return Next::again;
}

SurfaceFollower::Next SurfaceFollower::reach_vertex(int corner) noexcept {
  stand_on_face(a().shape.corner(corner));
  corner_ = corner;
  if (!collect_fan()) {
    corner_ = -1;
    return Next::unwalkable;
  }
  on_ = Stand::vertex;
  return Next::again;
}

// Onto the face that leads nearer to the device; else along the edge, which is concave.
SurfaceFollower::Next SurfaceFollower::descend_on_edge(const Vec3& device) noexcept {
  if (is_free_over_edge(device)) return Next::airborne;
  const double in_a = has_left_a_ ? 0.0 : inside_by(kOnEdge, a(), edge_, device);
  const double in_b = inside_by(kOnEdge, b(), other_edge_, device);
  const bool to_a = in_a > 0.0 && a().height(device) <= kClear;
  const bool to_b = in_b > 0.0 && b().height(device) <= kClear;
  if (to_b && !(to_a && in_a > in_b)) {
    cross_edge();
    return Next::again;
  }
  if (to_a) {
    stand_on_face(p_);
    came_by_ = edge_;
    return Next::again;
  }
  const ContactTriangle& face = a().shape;
  const double along = face.along(edge_, device);
  const double length = std::sqrt(face.edge(edge_).squaredNorm());
  if (along * length <= kSnap) return reach_vertex(edge_);
  if ((1.0 - along) * length <= kSnap) return reach_vertex((edge_ + 1) % 3);
  p_ = face.corner(edge_) + along * face.edge(edge_);
  has_left_a_ = false;
  return Next::settled;
}

// All triangle sides round the vertex, in order. False unless each can be walked.
bool SurfaceFollower::collect_fan() noexcept {
  fan_count_ = 0;
  std::uint32_t id = a().id;
  bool back = a().is_back();
  int corner = corner_;
  int next = corner_;
  do {
    if (fan_count_ == kMostFan || !holds(id, back)) return false;
    const ObjectGeometry::Corners corners = geometry_.corners(id);
    const std::array<const Vec3*, 3> at = {&corners.a, &corners.b, &corners.c};
    const Vec3& vertex = *at[corner];
    const Vec3 out = *at[(corner + 1) % 3] - vertex;
    const Vec3 in = vertex - *at[(corner + 2) % 3];
    const Vec3 normal = accurate_cross(out, -in).normalized();
    FanFacet& facet = fan_[fan_count_++];
    facet = {.id = id,
             .back = back,
             .corner = corner,
             .next = next,
             .normal = back ? Vec3(-normal) : normal,
             .inward = {normal.cross(out), normal.cross(in)},
             .direction = next == corner ? Vec3(out.normalized()) : Vec3(-in.normalized())};
    const TouchGeometry::Across across = geometry_.across(id, next);
    if (!across.exists) return false;
    const std::uint32_t number = corners.vertices[corner];
    id = across.id;
    back = back != across.flips;
    const Triangle& vertices = geometry_.corners(id).vertices;
    if (vertices[across.edge] == number) {
      corner = across.edge;
      next = (across.edge + 2) % 3;
    } else {
      corner = (across.edge + 1) % 3;
      next = corner;
    }
  } while (id != a().id || back != a().is_back());
  return true;
}

// A way nearer to the device that is no longer than this is none: its slope is all rounding.
double SurfaceFollower::least_slope(const Vec3& device) const noexcept { return kLeastWay + 0x1p-40 * (device - p_).norm(); }

// Whether a direction that leads farther from every edge and face round the vertex leads off the surface: by the normal of the vertex, each
// face's weighted by its angle (Baerentzen & Aanaes 2005). Pre: the vertex is the point of its faces nearest to there.
bool SurfaceFollower::is_free_at_vertex(const Vec3& to_device) const noexcept {
  if (!(to_device.norm() > kLeastWay)) return false;  // too near to tell
  const auto fan = std::span(fan_).first(static_cast<std::size_t>(fan_count_));
  if (std::none_of(fan.begin(), fan.end(), [&](const FanFacet& facet) { return facet.normal.dot(to_device) > 0.0; })) return false;
  double sum = 0.0;
  for (int i = 0; i < fan_count_; ++i) {
    const Vec3& first = fan_[(i + fan_count_ - 1) % fan_count_].direction;
    const Vec3& last = fan_[i].direction;
    sum += std::atan2(first.cross(last).norm(), first.dot(last)) * fan_[i].normal.dot(to_device);
  }
  return sum > 0.0;
}

// The steepest way: to the projection of the device on one of the faces or edges round the vertex, whichever is nearest to it.
SurfaceFollower::Next SurfaceFollower::descend_at_vertex(const Vec3& device) noexcept {
  const Vec3 to_device = device - p_;
  double best = least_slope(device);
  int at = -1;
  bool is_face = false;
  for (int i = 0; i < fan_count_; ++i) {
    const FanFacet& facet = fan_[i];
    const double slope = facet.direction.dot(to_device);
    if (slope > best) {
      best = slope;
      at = i;
      is_face = false;
    }
    if (facet.inward[0].dot(to_device) > 0.0 && facet.inward[1].dot(to_device) > 0.0) {
      const double length = (to_device - facet.normal.dot(to_device) * facet.normal).norm();
      if (length >= best) {
        best = length;
        at = i;
        is_face = true;
      }
    }
  }
  if (at < 0) return is_free_at_vertex(to_device) ? Next::airborne : Next::settled;
  const FanFacet& facet = fan_[at];
  load(facet.id, facet.back, a());
  if (is_face) {
    if (a().height(device) > kClear) {
      corner_ = facet.corner;  // stays at the vertex, which it leaves through the air
      return Next::airborne;
    }
    stand_on_face(p_);
    corner_ = facet.corner;
    return Next::again;
  }
  edge_ = facet.next;
  corner_ = facet.corner;
  if (!load_neighbour()) return Next::unwalkable;
  if (is_free_over_edge(device)) return Next::airborne;
  on_ = Stand::edge;
  has_left_a_ = false;
  corner_ = -1;
  return Next::again;
}

SurfaceFollower::Next SurfaceFollower::follow_on_face(const Vec3& from, const Vec3& to, double& time) noexcept {
  const double height = a().height(to);
  double soonest = 2.0;
  int exit = -1;
  for (int k = 0; k < 3; ++k) {
    const double there = inside_by(-kOnEdge, a(), k, to);
    if (there > 0.0) continue;
    const double t = time_of_zero(std::max(inside_by(-kOnEdge, a(), k, from), 0.0), there, time);
    if (t < soonest) {
      soonest = t;
      exit = k;
    }
  }
  if (height > kClear) {
    const double t = time_of_zero(std::min(a().height(from) - kClear, 0.0), height - kClear, time);
    if (t <= soonest) {
      time = t;
      return release(on_way(from, to, t), to);
    }
  }
  if (exit < 0) {
    time = 1.0;
    const Next next = settle_on_face(to - height * a().normal(), to);
    return next == Next::again ? Next::descend : next;
  }
  // Back over the edge that it has just come by, to where the other face says the same: both are rounding, the edge holds it.
  const bool turns_back = exit == came_by_ && soonest <= time;
  time = soonest;
  const Vec3 device = on_way(from, to, time);
  const Next next = reach_edge(exit, device - a().height(device) * a().normal());
  if (turns_back && on_ == Stand::edge) has_left_a_ = false;
  return next != Next::again || (turns_back && on_ == Stand::edge) ? next : Next::descend;
}

// The device comes to the free side of the face, at `at`. By an edge, it may go on behind the face beyond.
SurfaceFollower::Next SurfaceFollower::release(const Vec3& at, const Vec3& to) noexcept {
  const ContactTriangle& face = a().shape;
  stand_on_face(at - a().height(at) * a().normal());
  for (int k = 0; k < 3; ++k) {
    const double inside = face.inside(k, p_);
    const double length_squared = face.edge(k).squaredNorm();
    if (inside * std::fabs(inside) > kSnap * kSnap * length_squared) continue;
    const Next next = reach_edge(k, p_);
    if (next != Next::again) return next;
    if (on_ == Stand::edge && is_free_over_edge(to)) return Next::released;
    has_left_a_ = false;
    return on_ == Stand::edge ? Next::again : Next::descend;
  }
  return Next::released;
}

SurfaceFollower::Next SurfaceFollower::follow_on_edge(const Vec3& from, const Vec3& to, double& time) noexcept {
  const ContactTriangle& face = a().shape;
  double soonest = 2.0;
  enum class Event : std::uint8_t { none, to_a, to_b, begin, end } event = Event::none;
  const auto consider = [&](double at_0, double at_1, Event which) {
    const double t = time_of_zero(at_0, at_1, time);
    if (t < soonest) {
      soonest = t;
      event = which;
    }
  };
  const double in_a = inside_by(kOnEdge, a(), edge_, to);
  const double in_b = inside_by(kOnEdge, b(), other_edge_, to);
  if (in_a > 0.0) consider(std::min(inside_by(kOnEdge, a(), edge_, from), 0.0), in_a, Event::to_a);
  if (in_b > 0.0) consider(std::min(inside_by(kOnEdge, b(), other_edge_, from), 0.0), in_b, Event::to_b);
  const double along = face.along(edge_, to);
  const double along_before = face.along(edge_, from);
  if (along <= 0.0) consider(std::max(along_before, 0.0), along, Event::begin);
  if (along >= 1.0) consider(std::min(along_before - 1.0, 0.0), along - 1.0, Event::end);
  time = event == Event::none ? 1.0 : soonest;
  if (event == Event::begin || event == Event::end) {
    const Next next = reach_vertex(event == Event::begin ? edge_ : (edge_ + 1) % 3);
    return next == Next::again ? Next::descend : next;
  }
  const double here = std::clamp(face.along(edge_, on_way(from, to, time)), 0.0, 1.0);
  p_ = face.corner(edge_) + here * face.edge(edge_);
  // Only by rounding, near the vertex it came from, can it have taken an edge that the device is on the free side of.
  if (event == Event::none) return is_free_over_edge(to) ? Next::airborne : Next::settled;
  if (event == Event::to_b) {
    cross_edge();
    return Next::again;
  }
  stand_on_face(p_);
  came_by_ = edge_;
  return Next::again;
}

SurfaceFollower::Next SurfaceFollower::follow_at_vertex(const Vec3& from, const Vec3& to, double& time) noexcept {
  // Twice what a way must have to be taken: what is found here is taken.
  const double least = 2.0 * std::max(least_slope(from), least_slope(to));
  double soonest = 2.0;
  for (int i = 0; i < fan_count_; ++i) {
    const double there = fan_[i].direction.dot(to - p_) - least;
    if (!(there > 0.0)) continue;
    soonest = std::min(soonest, time_of_zero(std::min(fan_[i].direction.dot(from - p_) - least, 0.0), there, time));
  }
  if (soonest > 1.0) {
    time = 1.0;
    return is_free_at_vertex(to - p_) ? Next::airborne : Next::settled;
  }
  time = soonest;
  return Next::descend;
}

SurfaceFollower::Inside SurfaceFollower::inside(double off_edges) const noexcept {
  const ContactTriangle& face = a().shape;
  const Vec3 to_middle = (face.corner(0) + face.corner(1) + face.corner(2)) / 3.0 - p_;
  const double length = to_middle.norm();
  const double share = length > 2.0 * off_edges ? off_edges / length : 0.5;
  return {a().id, p_ + share * to_middle, a().normal()};
}

Vec3 SurfaceFollower::lifted(double height) const noexcept {
  if (on_ == Stand::edge) return p_ + between(a().normal(), b().normal(), height);
  std::array<ContactPlane, kMostFan> planes;
  Vec3 sum = Vec3::Zero();
  int count = 0;
  const auto add = [&](const Vec3& normal, double over) {
    planes[count++] = {normal, height - over};
    sum += normal;
  };
  if (on_ == Stand::vertex) {
    for (int i = 0; i < fan_count_; ++i) add(fan_[i].normal, 0.0);
  } else {
    add(a().normal(), 0.0);
    add_near_planes(height, add);
  }
  if (count == 1) return p_ + height * a().normal();
  const ConstrainedMotion up =
      constrain_motion(Vec3::Zero(), std::span<const ContactPlane>(planes.data(), static_cast<std::size_t>(count)));
  if (up.solved && up.motion.norm() <= kSteepest * height) return p_ + up.motion;
  return p_ + height * (sum.norm() > 0.5 ? Vec3(sum.normalized()) : a().normal());
}

// The least way to `height` over two planes through zero.
Vec3 SurfaceFollower::between(const Vec3& normal_a, const Vec3& normal_b, double height) noexcept {
  const Vec3 sum = normal_a + normal_b;
  const double squared = sum.squaredNorm();
  return squared * kSteepest * kSteepest > 4.0 ? Vec3(sum * (2.0 * height / squared)) : Vec3(height * normal_a);
}

// On a face, by an edge that it meets another face at: as seen from there.
template <class Add>
void SurfaceFollower::add_near_planes(double height, Add&& add) const noexcept {
  for (int k = 0; k < 3; ++k) {
    const double inside = a().shape.inside(k, p_);
    const double near = kSteepest * height;
    if (inside > 0.0 && inside * inside > near * near * a().shape.edge(k).squaredNorm()) continue;
    const TouchGeometry::Across across = geometry_.across(a().id, k);
    if (!across.exists || across.id == a().id) continue;
    Facet beyond;
    load(across.id, a().is_back() != across.flips, beyond);
    if (beyond.height(a().shape.corner((k + 2) % 3)) > 0.0) add(beyond.normal(), beyond.height(p_));
  }
}

int SurfaceFollower::find_contacts(const Vec3& device, std::array<Contact, 3>& contacts) const noexcept {
  const Vec3 to_device = device - p_;
  if (on_ == Stand::face) {
    contacts[0] = {a().id, a().normal(), -a().normal().dot(to_device)};
    return 1;
  }
  if (on_ == Stand::edge) {
    const double cosine = a().normal().dot(b().normal());
    const double at_a = -a().normal().dot(to_device);
    const double at_b = -b().normal().dot(to_device);
    const double determinant = 1.0 - cosine * cosine;
    const double of_a = determinant > 0.0 ? std::max(0.0, (at_a - cosine * at_b) / determinant) : at_a;
    const double of_b = determinant > 0.0 ? std::max(0.0, (at_b - cosine * at_a) / determinant) : 0.0;
    contacts[0] = {a().id, a().normal(), of_a};
    contacts[1] = {b().id, b().normal(), of_b};
    return 2;
  }
  std::array<ContactPlane, kMostFan> planes;
  for (int i = 0; i < fan_count_; ++i) planes[i] = {fan_[i].normal, 0.0};
  const ConstrainedMotion held =
      constrain_motion(to_device, std::span<const ContactPlane>(planes.data(), static_cast<std::size_t>(fan_count_)));
  for (int i = 0; i < held.active_count; ++i) {
    const FanFacet& facet = fan_[held.active[i]];
    contacts[i] = {facet.id, facet.normal, held.push[i]};
  }
  return held.active_count;
}

}  // namespace hapton
