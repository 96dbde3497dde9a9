#include "core/force/proxy/facet_descent.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/force/contact_qp.h"

namespace hapton {
namespace {

constexpr double kLeastCosine = 0.5;  // of the angle to the first face's normal: 60 degrees
constexpr int kMostTurns = 48;

}  // namespace

bool FacetDescent::run(const Vec3& start, std::span<const Constraint> held, const Vec3& device) noexcept {
  point_count_ = 0;
  face_count_ = 0;
  constraint_count_ = 0;
  met_concave_edge_ = held.size() > 1;
  if (!begin(start, held)) return false;
  Next next = held.size() == 2 ? Next::edge : Next::face;
  for (int turn = 0; turn < kMostTurns && next != Next::done && next != Next::unclear; ++turn) {
    next = next == Next::face ? cross_face(device) : next == Next::edge ? follow_edge(device) : turn_corner(device);
  }
  if (next != Next::done) return false;
  const std::span points(points_.data(), static_cast<std::size_t>(point_count_));
  Box box;
  for (const Vec3& p : points) box.grow(p);
  return cache_.covers(box.inflated(margin_)) && is_clear(points);
}

// If the path as a whole is in doubt, its pieces may still be clear.
bool FacetDescent::is_clear(std::span<const Vec3> points) const {
  if (cache_.is_clear(points, margin_, faces())) return true;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    if (points.size() == 2 || !cache_.is_clear(points.subspan(i, 2), margin_, faces())) return false;
  }
  return true;
}

bool FacetDescent::begin(const Vec3& start, std::span<const Constraint> held) {
  at_ = {};
  if (held.empty() || held.size() > 2) return false;
  first_normal_ = held[0].normal;
  go_to(start);
  const std::uint32_t slot = held[0].slot;
  if (slot == TriangleCache::kNoSlot) return false;
  const ContactTriangle& face = cache_.shape(slot);
  move_to_face(add_facet(slot, held[0].normal.dot(face.normal()) > 0.0 ? 1.0 : -1.0), -1, -1);
  if (held.size() == 1) return true;
  for (int k = 0; k < 3; ++k) {
    const TriangleCache::Adjacent adjacent = cache_.adjacent(slot, k);
    if (adjacent.slot == TriangleCache::kNoSlot || adjacent.slot != held[1].slot) continue;
    const double along = std::clamp(face.along(k, start), 0.0, 1.0);
    if ((face.corner(k) + along * face.edge(k) - start).norm() > margin_) return false;
    return move_to_edge(k) && normal_of(at_.other).dot(held[1].normal) > 0.0;
  }
  return false;
}

Vec3 FacetDescent::projection_on(const Facet* facet, const Vec3& device) {
  const Vec3& normal = shape(facet).normal();
  return device - normal.dot(device - shape(facet).corner(0)) * normal;
}

// Towards the projection of the device on the face, to the first edge on that path.
FacetDescent::Next FacetDescent::cross_face(const Vec3& device) {
  const ContactTriangle& face = shape(at_.facet);
  if (!(normal_of(at_.facet).dot(device - face.corner(0)) < 0.0)) return Next::unclear;  // the device is on the free side
  const Vec3& here = points_[point_count_ - 1];
  Vec3 projection = projection_on(at_.facet, device);
  if (has_friction_ && !apply_friction(device, projection, projection))
    return point_count_ == 1 ? settle_on_face(device, here) : Next::unclear;
  std::array<double, 3> inside;
  std::array<double, 3> there;
  unsigned beyond = 0;  // bit k: the projection lies beyond edge k; a mask, because a branch here would often be mispredicted
  for (int k = 0; k < 3; ++k) {
    inside[k] = face.inside(k, here);
    there[k] = face.inside(k, projection);
    beyond |= there[k] > 0.0 ? 0U : 1U << k;
  }
  if (at_.corner >= 0) beyond &= 1U << ((at_.corner + 1) % 3);  // the other two edges meet at the start
  if (beyond == 0) return settle_on_face(device, projection);
  if (at_.edge >= 0 && (beyond >> at_.edge & 1U) != 0) return move_to_edge(at_.edge) ? Next::edge : Next::unclear;
  int exit = -1;
  double soonest = 1.0;
  for (unsigned left = beyond; left != 0; left &= left - 1) {
    const int k = std::countr_zero(left);
    if (!(inside[k] > 0.0)) return Next::unclear;
    const double t = inside[k] / (inside[k] - there[k]);
    exit = t < soonest ? k : exit;
    soonest = std::min(soonest, t);
  }
  if (exit < 0) return settle_on_face(device, projection);
  const Vec3 bend = here + soonest * (projection - here);
  const double length = face.edge(exit).norm();
  const double along = face.along(exit, bend);
  if (along * length <= margin_ || (1.0 - along) * length <= margin_) {
    move_to_face(at_.facet, -1, along < 0.5 ? exit : (exit + 1) % 3);
    return go_to(face.corner(at_.corner)) ? Next::corner : Next::unclear;
  }
  return move_to_edge(exit) && go_to(bend) ? Next::edge : Next::unclear;
}

// Onto the face that leads away from the edge; if neither does, the edge is concave and the path follows it.
FacetDescent::Next FacetDescent::follow_edge(const Vec3& device) {
  const ContactTriangle& face = shape(at_.facet);
  const bool leaves_to_facet = face.inside(at_.edge, projection_on(at_.facet, device)) > 0.0;
  const bool leaves_to_other = shape(at_.other).inside(at_.other_edge, projection_on(at_.other, device)) > 0.0;
  if (leaves_to_facet && leaves_to_other) return Next::unclear;
  if (leaves_to_facet || leaves_to_other) {
    move_to_face(leaves_to_facet ? at_.facet : at_.other, leaves_to_facet ? at_.edge : at_.other_edge, -1);
    return Next::face;
  }
  met_concave_edge_ = true;
  if (has_friction_) return Next::unclear;
  const double length = face.edge(at_.edge).norm();
  const double along = face.along(at_.edge, device);
  if (along * length > margin_ && (1.0 - along) * length > margin_) {
    return settle_in_concave_edge(device, face.corner(at_.edge) + along * face.edge(at_.edge));
  }
  const int corner = along < 0.5 ? at_.edge : (at_.edge + 1) % 3;
  move_to_face(at_.facet, -1, corner);
  return go_to(face.corner(corner)) ? Next::corner : Next::unclear;
}

// Continues from a vertex over the one face, or along the one concave edge, that leads nearer to the device. At a saddle there are several;
// the choice then depends on the probe's radius and is left to the general method.
FacetDescent::Next FacetDescent::turn_corner(const Vec3& device) {
  met_concave_edge_ = true;
  if (has_friction_) return Next::unclear;
  Fan fan;
  std::array<int, kMaxFan> corners;
  int count = 0;
  if (!collect_fan(fan, corners, count)) return Next::unclear;
  const Vec3 here = points_[point_count_ - 1];
  const Vec3 goal = device - here;
  const double least = margin_ * 0x1p-10;
  Next next = Next::unclear;
  State state;
  for (int i = 0; i < count; ++i) {
    // The edge from this vertex to the next belongs to this facet and, if oriented alike, to the one before; the third edge is shared with
    // the one after.
    const int j = (i + 1) % count;
    const ContactTriangle& face = shape(fan[i]);
    const int first = corners[i];
    const int last = (corners[i] + 2) % 3;
    if (!(normal_of(fan[i]).dot(goal) < 0.0)) return Next::unclear;
    const Vec3 projection = projection_on(fan[i], device);
    const bool inside_first = face.inside(first, projection) > 0.0;
    const bool inside_last = face.inside(last, projection) > 0.0;
    if (inside_first && inside_last) {
      if ((projection - here).norm() <= least) continue;
      if (next != Next::unclear) return Next::unclear;
      next = Next::face;
      state = {.facet = fan[i], .corner = corners[i]};
      continue;
    }
    // The edge shared with the next facet of the fan.
    const int shared = fan[i]->side > 0.0 ? last : first;
    const Vec3 direction = shared == first ? face.edge(first) : Vec3(-face.edge(last));
    if (direction.dot(goal) <= least * direction.norm() || face.inside(shared, projection) > 0.0) continue;
    int other_edge = -1;
    const Facet* other = find_other(*fan[i], shared, other_edge);
    if (other == nullptr || other != fan[j]) return Next::unclear;
    if (shape(other).inside(other_edge, projection_on(other, device)) > 0.0) continue;
    if (next != Next::unclear) return Next::unclear;
    next = Next::edge;
    state = {.facet = fan[i], .other = other, .edge = shared, .other_edge = other_edge};
  }
  at_ = state;
  return next;
}

// All facets at a vertex, in order. False unless they form one closed fan that covers the vertex once.
bool FacetDescent::collect_fan(Fan& fan, std::array<int, kMaxFan>& corners, int& count) {
  const Facet* facet = at_.facet;
  int corner = at_.corner;
  do {
    if (count == kMaxFan) return false;
    fan[count] = facet;
    corners[count] = corner;
    ++count;
    const int shared = facet->side > 0.0 ? (corner + 2) % 3 : corner;
    int edge = -1;
    facet = find_other(*facet, shared, edge);
    if (facet == nullptr) return false;
    // Seen from the next facet on the same side, the shared edge begins here.
    corner = facet->side > 0.0 ? edge : (edge + 1) % 3;
  } while (facet != at_.facet);
  return cache_.count_at_vertex(at_.facet->slot, at_.corner) == count &&
         winds_once(std::span(fan).first(static_cast<std::size_t>(count)), std::span(corners).first(static_cast<std::size_t>(count)));
}

// True if a ray from the vertex over the middle of the first facet, projected along the first normal, crosses no other facet.
bool FacetDescent::winds_once(std::span<const Facet* const> fan, std::span<const int> corners) {
  const auto out = [&](std::size_t i, bool first) {
    const ContactTriangle& face = shape(fan[i]);
    return first ? face.edge(corners[i]) : Vec3(-face.edge((corners[i] + 2) % 3));
  };
  Vec3 ray = out(0, true).normalized() + out(0, false).normalized();
  ray -= first_normal_.dot(ray) * first_normal_;
  for (std::size_t i = 1; i < fan.size(); ++i) {
    const Vec3 sideways = first_normal_.cross(ray) * fan[i]->side;
    const double before = out(i, true).dot(sideways);
    const double after = out(i, false).dot(sideways);
    const bool is_ahead = out(i, true).dot(ray) * after >= out(i, false).dot(ray) * before;
    if (before <= 0.0 && after >= 0.0 && is_ahead) return false;
  }
  return true;
}

// The adjacent facet, which is added to the path; nullptr if the surface is not locally manifold there or the facet is too inclined.
const FacetDescent::Facet* FacetDescent::find_other(const Facet& facet, int edge, int& other_edge) {
  const TriangleCache::Adjacent adjacent = cache_.adjacent(facet.slot, edge);
  if (adjacent.slot == TriangleCache::kNoSlot) return nullptr;
  other_edge = adjacent.edge;
  const Facet* other = add_facet(adjacent.slot, adjacent.same_orientation ? facet.side : -facet.side);
  return other != nullptr && normal_of(other).dot(first_normal_) >= kLeastCosine ? other : nullptr;
}

bool FacetDescent::move_to_edge(int edge) {
  at_.edge = edge;
  at_.corner = -1;
  at_.other = find_other(*at_.facet, edge, at_.other_edge);
  return at_.other != nullptr;
}

void FacetDescent::move_to_face(const Facet* facet, int edge, int corner) {
  at_.facet = facet;
  at_.edge = edge;
  at_.corner = corner;
}

bool FacetDescent::go_to(const Vec3& p) {
  if (point_count_ == kMaxPoints) return false;
  points_[point_count_++] = p;
  return true;
}

// nullptr if there is no room, or if the path met this face on its other side.
const FacetDescent::Facet* FacetDescent::add_facet(std::uint32_t slot, double side) {
  for (int i = 0; i < face_count_; ++i) {
    if (faces_[i] == slot) return facets_[i].side == side ? &facets_[i] : nullptr;
  }
  if (face_count_ == kMaxFaces) return nullptr;
  faces_[face_count_] = slot;
  Facet& facet = facets_[face_count_++];
  facet.slot = slot;
  facet.side = side;
  facet.shape = &cache_.shape(slot);
  return &facet;
}

FacetDescent::Next FacetDescent::settle_on_face(const Vec3& device, const Vec3& goal) {
  const ContactTriangle& face = shape(at_.facet);
  const Vec3 normal = normal_of(at_.facet);
  const Vec3 height = normal.dot(goal - face.corner(0)) * normal;  // `goal` may be off the surface by the contact offset
  if (face.is_near_boundary(goal - height, margin_) || !go_to(goal)) return Next::unclear;
  constraints_[0] = {at_.facet->slot, normal, rest_offset_ - normal.dot(device - face.corner(0))};
  constraint_count_ = 1;
  end_ = goal - height + rest_offset_ * normal;
  return Next::done;
}

// How far friction lets the point go towards the projection of the device; false: it sticks.
bool FacetDescent::apply_friction(const Vec3& device, const Vec3& projection, Vec3& goal) {
  const Vec3& here = points_[point_count_ - 1];
  const double depth = rest_offset_ - normal_of(at_.facet).dot(device - shape(at_.facet).corner(0));
  const double length = (projection - here).norm();
  const double hold = (slides_ ? friction_.sliding : friction_.at_rest) * depth;
  if (length <= hold + rest_offset_) {
    slides_ = slides_ && length >= 0.5 * friction_.sliding * depth;
    return false;
  }
  slides_ = true;
  goal = projection - (friction_.sliding * depth / length) * (projection - here);
  return true;
}

FacetDescent::Next FacetDescent::settle_in_concave_edge(const Vec3& device, const Vec3& on_edge) {
  const std::array<const Facet*, 2> facets = {at_.facet, at_.other};
  std::array<ContactPlane, 2> planes;
  for (int i = 0; i < 2; ++i) planes[i] = {normal_of(facets[i]), rest_offset_};
  const ConstrainedMotion motion = constrain_motion(device - on_edge, planes);
  if (!motion.solved || motion.active_count != 2 || motion.motion.norm() > margin_ || !go_to(on_edge)) return Next::unclear;
  for (int i = 0; i < 2; ++i) {
    const int plane = motion.active[i];
    constraints_[i] = {facets[plane]->slot, planes[plane].normal, motion.multipliers[i]};
  }
  constraint_count_ = 2;
  end_ = on_edge + motion.motion;
  return Next::done;
}

}  // namespace hapton
