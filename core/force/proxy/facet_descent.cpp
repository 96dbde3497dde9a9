#include "core/force/proxy/facet_descent.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/force/contact_qp.h"

namespace hapton {
namespace {

constexpr double kMostLean = 0.5;  // cosine
constexpr int kMostTurns = 48;

}  // namespace

bool FacetDescent::run(const Vec3& start, std::span<const Hold> held, const Vec3& device) noexcept {
  point_count_ = 0;
  face_count_ = 0;
  hold_count_ = 0;
  met_fold_ = held.size() > 1;
  if (!begin(start, held)) return false;
  Next next = held.size() == 2 ? Next::edge : Next::face;
  for (int turn = 0; turn < kMostTurns && next != Next::done && next != Next::unclear; ++turn) {
    next = next == Next::face ? cross_face(device) : next == Next::edge ? follow_edge(device) : turn_corner(device);
  }
  if (next != Next::done) return false;
  const std::span points(points_.data(), static_cast<std::size_t>(point_count_));
  Box box;
  for (const Vec3& p : points) box.grow(p);
  return near_.covers(box.inflated(margin_)) && is_clear(points);
}

// What the way as a whole leaves in doubt, its pieces may settle.
bool FacetDescent::is_clear(std::span<const Vec3> points) const {
  if (near_.is_clear(points, margin_, faces())) return true;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    if (points.size() == 2 || !near_.is_clear(points.subspan(i, 2), margin_, faces())) return false;
  }
  return true;
}

bool FacetDescent::begin(const Vec3& start, std::span<const Hold> held) {
  at_ = {};
  if (held.empty() || held.size() > 2) return false;
  first_normal_ = held[0].normal;
  go_to(start);
  const std::uint32_t place = held[0].place;
  if (place == Neighbourhood::kNowhere) return false;
  const ContactTriangle& face = near_.shape(place);
  stand_on_face(add_facet(place, held[0].normal.dot(face.normal()) > 0.0 ? 1.0 : -1.0), -1, -1);
  if (held.size() == 1) return true;
  for (int k = 0; k < 3; ++k) {
    const Neighbourhood::Across across = near_.across(place, k);
    if (across.place == Neighbourhood::kNowhere || across.place != held[1].place) continue;
    const double along = std::clamp(face.along(k, start), 0.0, 1.0);
    if ((face.corner(k) + along * face.edge(k) - start).norm() > margin_) return false;
    return stand_on_edge(k) && normal_of(at_.other).dot(held[1].normal) > 0.0;
  }
  return false;
}

Vec3 FacetDescent::foot_on(const Facet* facet, const Vec3& device) {
  const Vec3& normal = shape(facet).normal();
  return device - normal.dot(device - shape(facet).corner(0)) * normal;
}

// Towards the foot of the device on the face, over the edge that is met first.
FacetDescent::Next FacetDescent::cross_face(const Vec3& device) {
  const ContactTriangle& face = shape(at_.facet);
  if (!(normal_of(at_.facet).dot(device - face.corner(0)) < 0.0)) return Next::unclear;  // the device is outside
  const Vec3& here = points_[point_count_ - 1];
  Vec3 foot = foot_on(at_.facet, device);
  if (rubs_ && !rub(device, foot, foot)) return point_count_ == 1 ? rest_on_face(device, here) : Next::unclear;
  std::array<double, 3> inside;
  std::array<double, 3> there;
  unsigned beyond = 0;  // the edges that the foot lies beyond, gathered first: which ones they are, no processor can guess
  for (int k = 0; k < 3; ++k) {
    inside[k] = face.inside(k, here);
    there[k] = face.inside(k, foot);
    beyond |= there[k] > 0.0 ? 0U : 1U << k;
  }
  if (at_.corner >= 0) beyond &= 1U << ((at_.corner + 1) % 3);  // the others meet here
  if (beyond == 0) return rest_on_face(device, foot);
  if (at_.edge >= 0 && (beyond >> at_.edge & 1U) != 0) return stand_on_edge(at_.edge) ? Next::edge : Next::unclear;
  int exit = -1;
  double soonest = 1.0;
  for (unsigned left = beyond; left != 0; left &= left - 1) {
    const int k = std::countr_zero(left);
    if (!(inside[k] > 0.0)) return Next::unclear;
    const double t = inside[k] / (inside[k] - there[k]);
    exit = t < soonest ? k : exit;
    soonest = std::min(soonest, t);
  }
  if (exit < 0) return rest_on_face(device, foot);
  const Vec3 bend = here + soonest * (foot - here);
  const double length = face.edge(exit).norm();
  const double along = face.along(exit, bend);
  if (along * length <= margin_ || (1.0 - along) * length <= margin_) {
    stand_on_face(at_.facet, -1, along < 0.5 ? exit : (exit + 1) % 3);
    return go_to(face.corner(at_.corner)) ? Next::corner : Next::unclear;
  }
  return stand_on_edge(exit) && go_to(bend) ? Next::edge : Next::unclear;
}

// Over the edge where either face leads away from it, else along it: a fold holds the point.
FacetDescent::Next FacetDescent::follow_edge(const Vec3& device) {
  const ContactTriangle& face = shape(at_.facet);
  const bool leaves_to_facet = face.inside(at_.edge, foot_on(at_.facet, device)) > 0.0;
  const bool leaves_to_other = shape(at_.other).inside(at_.other_edge, foot_on(at_.other, device)) > 0.0;
  if (leaves_to_facet && leaves_to_other) return Next::unclear;
  if (leaves_to_facet || leaves_to_other) {
    stand_on_face(leaves_to_facet ? at_.facet : at_.other, leaves_to_facet ? at_.edge : at_.other_edge, -1);
    return Next::face;
  }
  met_fold_ = true;
  if (rubs_) return Next::unclear;
  const double length = face.edge(at_.edge).norm();
  const double along = face.along(at_.edge, device);
  if (along * length > margin_ && (1.0 - along) * length > margin_) {
    return rest_in_fold(device, face.corner(at_.edge) + along * face.edge(at_.edge));
  }
  const int corner = along < 0.5 ? at_.edge : (at_.edge + 1) % 3;
  stand_on_face(at_.facet, -1, corner);
  return go_to(face.corner(corner)) ? Next::corner : Next::unclear;
}

// The one way down from a corner: over one of its faces, or along a fold between two. From a saddle more than one leads down, and the
// probe's own roundness decides.
FacetDescent::Next FacetDescent::turn_corner(const Vec3& device) {
  met_fold_ = true;
  if (rubs_) return Next::unclear;
  Fan fan;
  std::array<int, kMaxFan> corners;
  int count = 0;
  if (!collect_fan(fan, corners, count)) return Next::unclear;
  const Vec3 here = points_[point_count_ - 1];
  const Vec3 goal = device - here;
  const double least = margin_ * 0x1p-10;
  Next next = Next::unclear;
  Stand stand;
  for (int i = 0; i < count; ++i) {
    // The edge from this corner to the next belongs to this facet and, wound the same way, to the one before; the third edge is shared with
    // the one after.
    const int j = (i + 1) % count;
    const ContactTriangle& face = shape(fan[i]);
    const int first = corners[i];
    const int last = (corners[i] + 2) % 3;
    if (!(normal_of(fan[i]).dot(goal) < 0.0)) return Next::unclear;
    const Vec3 foot = foot_on(fan[i], device);
    const bool inside_first = face.inside(first, foot) > 0.0;
    const bool inside_last = face.inside(last, foot) > 0.0;
    if (inside_first && inside_last) {
      if ((foot - here).norm() <= least) continue;
      if (next != Next::unclear) return Next::unclear;
      next = Next::face;
      stand = {.facet = fan[i], .corner = corners[i]};
      continue;
    }
    // The edge shared with the next facet of the fan.
    const int shared = fan[i]->side > 0.0 ? last : first;
    const Vec3 direction = shared == first ? face.edge(first) : Vec3(-face.edge(last));
    if (direction.dot(goal) <= least * direction.norm() || face.inside(shared, foot) > 0.0) continue;
    int other_edge = -1;
    const Facet* other = find_other(*fan[i], shared, other_edge);
    if (other == nullptr || other != fan[j]) return Next::unclear;
    if (shape(other).inside(other_edge, foot_on(other, device)) > 0.0) continue;
    if (next != Next::unclear) return Next::unclear;
    next = Next::edge;
    stand = {.facet = fan[i], .other = other, .edge = shared, .other_edge = other_edge};
  }
  at_ = stand;
  return next;
}

// All facets round a corner, in order; false unless they close one fan that goes round once.
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
    // Seen from the next, wound to the same side, the shared edge begins here.
    corner = facet->side > 0.0 ? edge : (edge + 1) % 3;
  } while (facet != at_.facet);
  return near_.count_round(at_.facet->place, at_.corner) == count &&
         winds_once(std::span(fan).first(static_cast<std::size_t>(count)), std::span(corners).first(static_cast<std::size_t>(count)));
}

// A ray from the corner over the middle of the first facet, seen along the first normal, lies in no other one.
bool FacetDescent::winds_once(std::span<const Facet* const> fan, std::span<const int> corners) {
  const auto out = [&](std::size_t i, bool first) {
    const ContactTriangle& face = shape(fan[i]);
    return first ? face.edge(corners[i]) : Vec3(-face.edge((corners[i] + 2) % 3));
  };
  Vec3 ray = out(0, true).normalized() + out(0, false).normalized();
  ray -= first_normal_.dot(ray) * first_normal_;
  for (std::size_t i = 1; i < fan.size(); ++i) {
    const Vec3 across = first_normal_.cross(ray) * fan[i]->side;
    const double before = out(i, true).dot(across);
    const double after = out(i, false).dot(across);
    const bool is_ahead = out(i, true).dot(ray) * after >= out(i, false).dot(ray) * before;
    if (before <= 0.0 && after >= 0.0 && is_ahead) return false;
  }
  return true;
}

// The facet beyond an edge, or none that is plain; it joins those touched.
const FacetDescent::Facet* FacetDescent::find_other(const Facet& facet, int edge, int& other_edge) {
  const Neighbourhood::Across across = near_.across(facet.place, edge);
  if (across.place == Neighbourhood::kNowhere) return nullptr;
  other_edge = across.edge;
  const Facet* other = add_facet(across.place, across.same_winding ? facet.side : -facet.side);
  return other != nullptr && normal_of(other).dot(first_normal_) >= kMostLean ? other : nullptr;
}

bool FacetDescent::stand_on_edge(int edge) {
  at_.edge = edge;
  at_.corner = -1;
  at_.other = find_other(*at_.facet, edge, at_.other_edge);
  return at_.other != nullptr;
}

void FacetDescent::stand_on_face(const Facet* facet, int edge, int corner) {
  at_.facet = facet;
  at_.edge = edge;
  at_.corner = corner;
}

bool FacetDescent::go_to(const Vec3& p) {
  if (point_count_ == kMaxPoints) return false;
  points_[point_count_++] = p;
  return true;
}

// None when there is no room, or when the face was touched on its other side.
const FacetDescent::Facet* FacetDescent::add_facet(std::uint32_t place, double side) {
  for (int i = 0; i < face_count_; ++i) {
    if (faces_[i] == place) return facets_[i].side == side ? &facets_[i] : nullptr;
  }
  if (face_count_ == kMaxFaces) return nullptr;
  faces_[face_count_] = place;
  Facet& facet = facets_[face_count_++];
  facet.place = place;
  facet.side = side;
  facet.shape = &near_.shape(place);
  return &facet;
}

FacetDescent::Next FacetDescent::rest_on_face(const Vec3& device, const Vec3& goal) {
  const ContactTriangle& face = shape(at_.facet);
  const Vec3 normal = normal_of(at_.facet);
  const Vec3 height = normal.dot(goal - face.corner(0)) * normal;  // `goal` may hover
  if (face.is_near_border(goal - height, margin_) || !go_to(goal)) return Next::unclear;
  holds_[0] = {at_.facet->place, normal, rest_ - normal.dot(device - face.corner(0))};
  hold_count_ = 1;
  end_ = goal - height + rest_ * normal;
  return Next::done;
}

// Where friction lets the point go on its way to the foot; false: it stays here.
bool FacetDescent::rub(const Vec3& device, const Vec3& foot, Vec3& goal) {
  const Vec3& here = points_[point_count_ - 1];
  const double push = rest_ - normal_of(at_.facet).dot(device - shape(at_.facet).corner(0));
  const double way = (foot - here).norm();
  const double hold = (slides_ ? friction_.sliding : friction_.at_rest) * push;
  if (way <= hold + rest_) {
    slides_ = slides_ && way >= 0.5 * friction_.sliding * push;
    return false;
  }
  slides_ = true;
  goal = foot - (friction_.sliding * push / way) * (foot - here);
  return true;
}

FacetDescent::Next FacetDescent::rest_in_fold(const Vec3& device, const Vec3& on_edge) {
  const std::array<const Facet*, 2> facets = {at_.facet, at_.other};
  std::array<ContactPlane, 2> planes;
  for (int i = 0; i < 2; ++i) planes[i] = {normal_of(facets[i]), rest_};
  const ConstrainedMotion motion = constrain_motion(device - on_edge, planes);
  if (!motion.solved || motion.active_count != 2 || motion.motion.norm() > margin_ || !go_to(on_edge)) return Next::unclear;
  for (int i = 0; i < 2; ++i) {
    const int plane = motion.active[i];
    holds_[i] = {facets[plane]->place, planes[plane].normal, motion.push[i]};
  }
  hold_count_ = 2;
  end_ = on_edge + motion.motion;
  return Next::done;
}

}  // namespace hapton
