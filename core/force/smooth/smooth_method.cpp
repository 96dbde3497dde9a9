#include "core/force/smooth/smooth_method.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/geometry/closest_point.h"
#include "core/geometry/triangle_distance.h"

namespace hapton {
namespace {

// Most projections of the VCP in a step, including the one of the FDH paper; they stop as soon as the VCP no longer moves.
constexpr int kMaxProjections = 6;
// Share of the tolerance by which the VCP stays outside the surface, so that rounding does not put it inside.
constexpr double kContactOffset = 0.01;
// In tolerances: how far a point steps back on the path of the probe from where the path reaches an edge, to find from which side it comes.
constexpr double kStepBack = 100.0;
// In diagonals of the scene: a probe farther out is clamped to this, so that its path keeps enough digits near the surface.
constexpr double kFarthest = 1e7;
// Most faces that the VCP may cross in a step.
constexpr int kLongestWalk = 256;
// Share of RADIUS: shorter motions count as zero.
constexpr double kStill = 1e-6;

// Whether the face is within `radius` of p. The distance from the plane rejects most faces before the triangle is tested.
bool is_within(const SetTriangle& face, const Vec3& p, double radius) {
  if (std::fabs(face.face_normal.dot(p - face.corner[0])) > radius * (1.0 + 1e-9)) return false;
  return triangle_distance_squared(p, face.corner[0], face.corner[1], face.corner[2]) <= radius * radius;
}

// Whether X, on the triangle's plane, lies inside all edges of the triangle by more than `margin`.
bool is_inside_edges(const SetTriangle& t, const Vec3& X, double margin) {
  for (int k = 0; k < 3; ++k) {
    const Vec3 e = t.corner[(k + 1) % 3] - t.corner[k];
    if (!(t.face_normal.cross(e).dot(X - t.corner[k]) > margin * e.norm())) return false;
  }
  return true;
}

// The position, 0 to 1, at which the path between two points is closest to a face; the first one if there are several. The distance to a
// triangle is convex along a line, so interval search finds it.
double nearest_on_path(const Vec3& from, const Vec3& to, const SetTriangle& t) {
  const auto distance = [&](double at) {
    return triangle_distance_squared(from + at * (to - from), t.corner[0], t.corner[1], t.corner[2]);
  };
  double low = 0.0;
  double high = 1.0;
  for (int i = 0; i < 60; ++i) {
    const double third = (high - low) / 3.0;
    if (distance(low + third) <= distance(high - third)) {
      high -= third;
    } else {
      low += third;
    }
  }
  return low;
}

}  // namespace

template <class Visit>
void SmoothMethod::visit_near(const Vec3& centre, double radius, Visit&& visit) noexcept {
  if (!all_triangles_ && (!is_fresh() || (set_.radius_at(centre) <= radius && new_set_could_cover(centre, radius)))) select_at(centre);
  if (all_triangles_ || set_.radius_at(centre) > radius) {
    for (const SetTriangle& t : query_triangles()) visit(t);
    return;
  }
  ++counters_.overflows;
  scene_->for_each_near(FdhBall{centre, radius}, visit);
}

template <class Visit>
void SmoothMethod::visit_along(const Vec3& from, const Vec3& to, Visit&& visit) noexcept {
  const double tolerance = 2.0 * scene_->tolerance();
  // A set's radius is concave along a line: if it covers both ends, it covers all between.
  const auto is_covered = [&] { return all_triangles_ || (set_.radius_at(from) > tolerance && set_.radius_at(to) > tolerance); };
  if (!all_triangles_ && (!is_fresh() || !is_covered())) select_at(to);
  if (is_covered()) {
    for (const SetTriangle& t : query_triangles()) visit(t);
    return;
  }
  ++counters_.overflows;
  scene_->for_each_near(FdhSweep{from, to, tolerance}, visit);
}

// The first face on the path of a free probe: one that the path passes through, or one that it comes within the tolerance of: at an edge or
// vertex, at the path's end, along a face, or where faces do not quite meet.
SmoothMethod::Hit SmoothMethod::find_entry(const Vec3& from, const Vec3& to) noexcept {
  Hit passed;
  Hit grazed;
  const double tolerance = scene_->tolerance();
  const auto p = of3(from);
  const auto q = of3(to);
  const StraightLine line(from, to);
  visit_along(from, to, [&](const SetTriangle& t) {
    if (!is_face(t)) return;
    const double start = t.face_normal.dot(from - t.corner[0]);
    const double end = t.face_normal.dot(to - t.corner[0]);
    if (std::min(std::fabs(start), std::fabs(end)) > tolerance && (start > 0.0) == (end > 0.0)) return;
    if (!(segment_triangle_distance_squared<double>(p, q, of3(t.corner[0]), of3(t.corner[1]), of3(t.corner[2])) <= tolerance * tolerance))
      return;
    const double side = start < 0.0 ? -1.0 : 1.0;
    double at = 0.0;
    if (std::fabs(start) > tolerance && side * end < -tolerance && line.meets(t.corner, at)) {
      at = std::clamp(at, 0.0, 1.0);
      const Vec3 X = from + at * (to - from);
      if (is_inside_edges(t, X, tolerance)) {
        if ((side > 0.0 || t.two_sided) && passed.is_worse_than(at, t)) passed = {t, X, at, side, true};
        return;
      }
    }
    at = nearest_on_path(from, to, t);
    if (grazed.is_worse_than(at, t)) grazed = {t, from + at * (to - from), at, side, true};
  });
  if (!grazed.found || (passed.found && passed.measure <= grazed.measure)) return passed;
  const Hit resolved = resolve_side(from, grazed);
  return resolved.found ? resolved : passed;
}

// At an edge or vertex, the heights above single faces do not tell which side the probe comes from. A point slightly back on its path does:
// of the faces closest to that point, the one whose normal is best aligned with the direction to the point tells the side. This needs no
// mean of normals as in Baerentzen & Aanaes 2005.
SmoothMethod::Hit SmoothMethod::resolve_side(const Vec3& from, const Hit& grazed) noexcept {
  const double tolerance = scene_->tolerance();
  const Vec3 back = from - grazed.X;
  const double length = back.norm();
  const double step = std::min(length, kStepBack * tolerance);
  if (!(step > 0.0)) return grazed;
  const Vec3 Q = grazed.X + (step / length) * back;
  double least = step + 2.0 * tolerance;
  visit_near(Q, least, [&](const SetTriangle& t) {
    if (is_face(t) && is_within(t, Q, least)) least = std::sqrt(triangle_distance_squared(Q, t.corner[0], t.corner[1], t.corner[2]));
  });
  Hit nearest;
  visit_near(Q, step + 2.0 * tolerance, [&](const SetTriangle& t) {
    if (!is_face(t) || !is_within(t, Q, least + 1e-6 * step)) return;
    const double height = t.face_normal.dot(Q - t.corner[0]);
    if (!nearest.is_worse_than(-std::fabs(height), t)) return;
    nearest = {t, closest_point(t.corner[0], t.corner[1], t.corner[2], grazed.X).point, -std::fabs(height), height < 0.0 ? -1.0 : 1.0,
               true};
  });
  if (!nearest.found) return grazed;
  if (nearest.side < 0.0 && !nearest.triangle.two_sided) return {};
  return nearest;
}

// The first face between a VCP (lifted off the surface) and the probe. It is mostly near the VCP, where the set is complete; only if there
// is none does the tree search the rest of the path.
SmoothMethod::Hit SmoothMethod::find_block(const Vec3& from, const Vec3& to) noexcept {
  Hit best;
  const double length = (to - from).norm();
  double search_end = 1.0;
  const StraightLine line(from, to);
  const auto test = [&](const SetTriangle& t) {
    if (!is_face(t)) return;
    const double start = side_ * t.face_normal.dot(from - t.corner[0]);
    const double end = side_ * t.face_normal.dot(to - t.corner[0]);
    if (!(start > 0.0 && end <= 0.0)) return;
    double at = 0.0;
    if (!line.meets(t.corner, at)) return;
    at = std::clamp(at, 0.0, 1.0);
    if (at <= search_end && best.is_worse_than(at, t)) best = {t, from + at * (to - from), at, side_, true};
  };
  if (all_triangles_) {
    for (const SetTriangle& t : all_) test(t);
    return best;
  }
  const double needed_radius = std::min(length, radius_) + scene_->tolerance();
  if (!is_fresh() || (set_.radius_at(from) <= needed_radius && new_set_could_cover(from, needed_radius))) select_at(from);
  const double radius = set_.radius_at(from) - scene_->tolerance();
  if (radius > 0.0) {
    search_end = length > radius ? radius / length : 1.0;
    for (const SetTriangle& t : query_triangles()) test(t);
    if (best.found || search_end >= 1.0) return best;
    search_end = 1.0;
  }
  ++counters_.overflows;
  scene_->for_each_near(FdhSweep{from, to, scene_->tolerance()}, test);
  return best;
}

// Fig. 4 (FDH): of the points where the line from P outward leaves the inside, the one nearest to `near`. If there is none and the mesh is
// inconsistently oriented, flipped two-sided faces count as well.
SmoothMethod::Hit SmoothMethod::find_on_line(const Vec3& P, const Vec3& outward, const Vec3& near, double radius) noexcept {
  Hit best;
  Hit flipped;
  const StraightLine line(P, P + outward);
  visit_near(near, radius, [&](const SetTriangle& t) {
    if (!is_face(t)) return;
    const double facing = side_ * outward.dot(t.face_normal);
    if (!(facing > 0.0) && (t.consistently_oriented || !t.two_sided || facing == 0.0)) return;
    double at = 0.0;
    if (!line.meets(t.corner, at)) return;
    const Vec3 X = P + at * outward;
    const double distance = (X - near).norm();
    Hit& hit = facing > 0.0 ? best : flipped;
    if (distance <= radius && hit.is_worse_than(distance, t)) hit = {t, X, distance, facing > 0.0 ? side_ : -side_, true};
  });
  return best.found ? best : flipped;
}

SmoothMethod::Hit SmoothMethod::find_nearest_face(const Vec3& p, double radius) noexcept {
  Hit best;
  visit_near(p, radius, [&](const SetTriangle& t) {
    if (!is_face(t) || !is_within(t, p, radius)) return;
    const double distance = std::sqrt(triangle_distance_squared(p, t.corner[0], t.corner[1], t.corner[2]));
    if (!best.is_worse_than(distance, t)) return;
    best = {t, closest_point(t.corner[0], t.corner[1], t.corner[2], p).point, distance, side_, true};
  });
  return best;
}

bool SmoothMethod::is_behind_all(const Vec3& P) noexcept {
  const double tolerance = scene_->tolerance();
  bool behind = side_ * T_.face_normal.dot(P - V_) < -tolerance;
  if (!behind) return false;
  visit_near(V_, tolerance, [&](const SetTriangle& t) {
    if (is_face(t) && is_within(t, V_, 0.5 * tolerance)) behind = behind && side_ * t.face_normal.dot(P - V_) < -tolerance;
  });
  return behind;
}

// Direction away from every face that p lies on.
Vec3 SmoothMethod::outward_at(const Vec3& p) noexcept {
  struct Face {
    std::uint32_t object;
    std::uint32_t triangle;
    Vec3 normal;
  };
  constexpr std::size_t kMax = 64;  // enough also for a vertex with more faces
  std::array<Face, kMax> faces;
  std::size_t count = 0;
  const double radius = 0.5 * scene_->tolerance();
  visit_near(p, radius, [&](const SetTriangle& t) {
    if (!is_face(t) || count == kMax || !is_within(t, p, radius)) return;
    std::size_t at = count++;
    for (; at > 0 && (faces[at - 1].object != t.object ? faces[at - 1].object > t.object : faces[at - 1].triangle > t.triangle); --at) {
      faces[at] = faces[at - 1];
    }
    faces[at] = {t.object, t.triangle, t.face_normal};
  });
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < count; ++i) sum += side_ * faces[i].normal;
  const double length = sum.norm();
  return length > 0.1 ? Vec3(sum / length) : Vec3(side_ * T_.face_normal);
}

// ---- tracking --------------------------------------------------------------------------------------------------------

void SmoothMethod::enter(const Hit& hit) noexcept {
  is_inside_ = true;
  stay_at(hit);
}

void SmoothMethod::stay_at(const Hit& hit) noexcept {
  V_ = hit.X;
  T_ = hit.triangle;
  side_ = hit.side;
}

// What lies between the VCP and another point on the surface, both seen from outside.
SmoothMethod::Hit SmoothMethod::find_obstacle(const SetTriangle& face, const Vec3& X) noexcept {
  const double lift = 2.0 * scene_->tolerance();
  return find_block(V_ + lift * outward_at(V_), X + (lift * side_) * face.face_normal);
}

// Moves V over the surface to the point nearest to P, from face to touching face, each step strictly nearer. True: V ends within a face.
// Where more than two faces meet, nothing may lie between V and its target: parts that merely touch or intersect are not connected.
bool SmoothMethod::descend(const Vec3& P) noexcept {
  const double touch_distance = 0.5 * scene_->tolerance();
  for (int i = 0; i < kLongestWalk; ++i) {
    const ClosestPoint on_face = closest_point(T_.corner[0], T_.corner[1], T_.corner[2], P);
    V_ = on_face.point;
    if (on_face.feature == TriangleFeature::face) return true;
    const Vec3 here = V_;
    const double distance = (P - here).norm();
    Hit best;
    best.measure = distance - 1e-9 * distance - 1e-3 * touch_distance;
    int neighbour_count = 0;
    visit_near(here, touch_distance, [&](const SetTriangle& t) {
      if (!is_face(t) || (t.object == T_.object && t.triangle == T_.triangle)) return;
      if (!is_within(t, here, touch_distance)) return;
      ++neighbour_count;
      const double other_distance = std::sqrt(triangle_distance_squared(P, t.corner[0], t.corner[1], t.corner[2]));
      if (other_distance > best.measure || (other_distance == best.measure && !t.before(best.triangle))) return;
      best.triangle = t;
      best.measure = other_distance;
      best.found = true;
    });
    if (!best.found) return false;
    if (neighbour_count > 1) {
      const auto& c = best.triangle.corner;
      const Hit obstacle = find_obstacle(best.triangle, closest_point(c[0], c[1], c[2], P).point);
      if (obstacle.found && !((P - obstacle.X).norm() < distance - 1e-9 * distance - touch_distance)) return false;
      if (obstacle.found) best.triangle = obstacle.triangle;
    }
    T_ = best.triangle;
  }
  return false;
}

// V1: D, where the line through P along the smooth normal at the VCP meets the surface, repeated until normal and VCP agree.
Vec3 SmoothMethod::project_smoothly(const Vec3& P, double radius, Vec3& normal) noexcept {
  Vec3 V = V_;
  SetTriangle T = T_;
  normal = side_ * smooth_normal_at(T, V);
  double last_motion = radius;
  for (int i = 0; i < kMaxProjections; ++i) {
    const Hit hit = find_on_line(P, normal, V, radius);
    // A longer motion than the last would not converge: P is deeper than the surface's radius of curvature.
    if (!hit.found || hit.measure > last_motion) break;
    V = hit.X;
    T = hit.triangle;
    normal = hit.side * smooth_normal_at(T, V);
    last_motion = hit.measure;
    if (last_motion <= kStill * radius_) break;
  }
  return V;
}

// Fig. 4 (FDH): moves V from the last sample to this one. False: the probe is outside again.
bool SmoothMethod::track(const Vec3& P) noexcept {
  const Vec3 move = P - P_;
  const Vec3 W = V_ + move;
  const double radius = std::max(radius_, 2.0 * move.norm());
  const double tolerance = scene_->tolerance();
  Vec3 outward = V_ - P_;
  const double depth = outward.norm();
  // If the line is too short to give a direction, or the surface has moved past the probe, the normal is used.
  const bool points_out = depth > 4.0 * tolerance && side_ * T_.face_normal.dot(outward) > 0.0;
  outward = points_out ? Vec3(outward / depth) : Vec3(side_ * smooth_normal_at(T_, V_));
  const Hit on_line = find_on_line(P, outward, W, radius);
  const bool stays = on_line.found && on_line.triangle.object == T_.object && on_line.triangle.triangle == T_.triangle;
  if (stays || (on_line.found && !find_obstacle(on_line.triangle, on_line.X).found)) stay_at(on_line);
  counters_.missed_lines += on_line.found ? 0 : 1;  // the current VCP stays
  return settle(P);
}

// Moves V to where it is nearest to P. False: the probe is outside.
bool SmoothMethod::settle(const Vec3& P) noexcept {
  const double tolerance = scene_->tolerance();
  if (descend(P) && side_ * T_.face_normal.dot(P - V_) <= tolerance) return true;

  // The probe is outside, unless P is behind every face that the VCP lies on, or a face lies between VCP and P.
  if (is_behind_all(P)) return true;
  for (int i = 0; i < 4; ++i) {
    const Hit block = find_block(V_ + 2.0 * tolerance * outward_at(V_), P);
    if (!block.found) break;
    stay_at(block);
    if (descend(P) && side_ * T_.face_normal.dot(P - V_) <= tolerance) return true;
    if (i == 3) return true;
  }
  const Hit touched = find_nearest_face(P, tolerance);
  if (touched.found) stay_at(touched);
  return touched.found;
}

// ---- force -----------------------------------------------------------------------------------------------------------

Vec3 SmoothMethod::outside_force(const Vec3& p) noexcept {
  if (!(layer_ > 0.0)) return Vec3::Zero();
  SmoothForceSum sum(p, radius_);
  visit_near(p, radius_, [&sum](const SetTriangle& t) { sum.add(t); });
  const SmoothForce sum_force = sum.combine(layer_, materials_);
  counters_.hidden += sum_force.hidden;
  counters_.over_capacity += sum_force.over_capacity;
  return sum_force.force_n;
}

MethodOutput SmoothMethod::compute_outside(const Vec3& P) noexcept {
  const Vec3 force_n = outside_force(P);
  return {.force_n = force_n, .p_SP = P, .contact = !force_n.isZero(0.0)};
}

MethodOutput SmoothMethod::compute_inside(const Vec3& P) noexcept {
  Vec3 n;
  Vec3 V = project_smoothly(P, radius_, n);
  V += kContactOffset * scene_->tolerance() * n;
  const Vec3 pull = V - P;
  Vec3 force_n = outside_force(V + 2.0 * scene_->tolerance() * n);
  // Within the tolerance the probe may still be on the outer side.
  if (pull.dot(n) > 0.0) force_n += materials_[T_.object].stiffness_n_per_m * pull;
  const bool pushes = !force_n.isZero(0.0);
  return {.force_n = force_n, .p_SP = pushes ? V : P, .contact = pushes, .object = pushes ? static_cast<int>(T_.object) : -1};
}

Vec3 SmoothMethod::within_limits(const Vec3& p) const noexcept {
  const double farthest = kFarthest * scene_->diagonal();
  const Vec3 out = p - scene_->centre();
  const double most = out.cwiseAbs().maxCoeff();
  return most > farthest ? Vec3(scene_->centre() + farthest * (out / most)) : p;
}

MethodOutput SmoothMethod::step(const MethodInput& input) noexcept {
  if (!input.p_SD.allFinite()) return {.force_n = Vec3::Zero(), .p_SP = P_};
  if (!has_started_) reset(input.p_SD);
  MethodOutput output = step_at(within_limits(input.p_SD), input.dt_s);
  if (!output.contact) output.p_SP = input.p_SD;
  return output;
}

MethodOutput SmoothMethod::step_at(const Vec3& P, double dt_s) noexcept {
  ++counters_.steps;
  if (sets_.take()) offer(sets_.value());
  const Vec3 move = P - P_;
  velocity_ = dt_s > 0.0 && std::isfinite(dt_s) ? Vec3(move / dt_s) : Vec3(Vec3::Zero());
  if (is_inside_ && !track(P)) {
    is_inside_ = false;
    ++counters_.releases;
    P_ = P;
    request_ahead();
    return compute_outside(P);
  }
  if (!is_inside_) {
    const double needed_clearance = std::max(layer_ > 0.0 ? radius_ : 0.0, 2.0 * scene_->tolerance());
    if (!all_triangles_ && is_fresh() && set_.clearance_at(P_) > needed_clearance && set_.clearance_at(P) > needed_clearance) {
      ++counters_.skipped;
      P_ = P;
      request_ahead();
      return {.force_n = Vec3::Zero(), .p_SP = P};
    }
    const Hit entry = find_entry(P_, P);
    if (entry.found) {
      ++counters_.entries;
      enter(entry);
      is_inside_ = settle(P);
    }
  }
  P_ = P;
  request_ahead();
  return is_inside_ ? compute_inside(P) : compute_outside(P);
}

void SmoothMethod::reset(const Vec3& p_SD) noexcept {
  is_inside_ = false;
  velocity_.setZero();
  has_started_ = p_SD.allFinite();
  if (has_started_) P_ = within_limits(p_SD);
}

}  // namespace hapton
