#pragma once

#include "core/collision/touch_geometry.h"
#include "core/geometry/contact_triangle.h"

namespace hapton {

// The distance that a probe keeps from surfaces, and its tolerances.
// A point probe is a sphere of radius `offset`, the contact offset alone; a sphere probe adds its radius.
// Frame and units: TouchGeometry's local ones (object_geometry.h), in which the scene's diagonal is between 1 and 2.
struct Clearance {
  double offset = 0.0;     // distance of a proxy in contact: its rest offset
  double slop = 0.0;       // the distance is never less than offset - slop, which is positive: no surface is ever crossed
  double tolerance = 0.0;  // how far from `offset` a motion may stop; far above rounding, far below slop
};

// The time of an event that does not happen; motions last from 0 to 1.
constexpr double kNever = 2.0;

// The functions below accept any shape with separation(p). A ContactTriangle is faster; a TriangleView needs no preparation.
struct TriangleView {
  const TouchGeometry& geometry;
  std::uint32_t triangle;
  Separation separation(const Vec3& p) const { return geometry.separation(triangle, p); }
};

// When a sphere's centre that moves from p along `motion` comes within `level` of a triangle: t in [from, 1], or kNever.
// The distance to a convex set along a line is convex, so Newton's tangent from the approaching side never oversteps the true
// root and converges quadratically: no feature cases, no cancelling discriminant, conservative at every iterate.
// Pre: distance at `from` is at least level. RT: yes.
template <class Shape>
double time_to_reach(const Shape& shape, const Vec3& p, const Vec3& motion, double from, double level, double tolerance) {
  constexpr int kMaxIterations = 48;  // quadratic convergence needs under ten; the bound only limits time
  const double length = motion.norm();
  double t = from;
  for (int i = 0; i < kMaxIterations; ++i) {
    const Separation now = shape.separation(p + t * motion);
    const double slope = now.normal.dot(motion) - normal_error(now) * length;  // at its steepest: never oversteps for rounding
    const double gap = now.distance - level;
    if (gap <= tolerance) return slope < 0.0 ? t : kNever;
    if (slope >= 0.0) return kNever;
    t += gap / -slope;
    if (!(t <= 1.0)) return kNever;
  }
  return t;
}

// Whether a sphere's centre that moves from p along `motion` comes nearer to a triangle than `level` between two times. Uses distances, not
// normals, which have rounding errors near an edge: the distance is convex along the path, so between two samples it lies above the
// straight lines through the samples on either side. Coming nearer by less than `tolerance` does not count. In doubt: true.
// Pre: at both times the distance is at least level. RT: yes.
template <class Shape>
bool comes_nearer(const Shape& shape, const Vec3& p, const Vec3& motion, double from, double until, double level, double tolerance) {
  constexpr int kMaxIterations = 64;  // each halves one interval that can hold the least distance
  struct Sample {
    double t = 0.0;
    double distance = 0.0;
  };
  const auto sample_at = [&](double t) { return Sample{t, shape.separation(p + t * motion).distance}; };
  const auto on_line = [](const Sample& a, const Sample& b, double t) {
    return a.distance + (b.distance - a.distance) * ((t - a.t) / (b.t - a.t));
  };
  Sample left = sample_at(from);
  Sample middle = sample_at(0.5 * (from + until));
  Sample right = sample_at(until);
  for (int i = 0; i < kMaxIterations; ++i) {
    if (middle.distance < level - tolerance) return true;
    if (!(left.t < middle.t && middle.t < right.t)) return false;
    if (std::min(on_line(middle, right, left.t), on_line(left, middle, right.t)) >= level - tolerance) return false;
    // The least distance lies in one of the two intervals beside the least sample.
    if (left.distance < middle.distance) {
      right = middle;
      middle = sample_at(0.5 * (left.t + right.t));
    } else if (right.distance < middle.distance) {
      left = middle;
      middle = sample_at(0.5 * (left.t + right.t));
    } else {
      const bool is_left = middle.t - left.t > right.t - middle.t;
      const Sample half = sample_at(0.5 * (middle.t + (is_left ? left.t : right.t)));
      if (half.distance < middle.distance) {
        (is_left ? right : left) = middle;
        middle = half;
      } else {
        (is_left ? left : right) = half;
      }
    }
  }
  return true;
}

// Does the same as comes_nearer, but tries the tangents first: where the normals are accurate, they decide most cases in a few steps.
template <class Shape>
bool dips_below(const Shape& shape, const Vec3& p, const Vec3& motion, double from, double until, double level, double tolerance) {
  constexpr int kFewIterations = 8;
  const double length = motion.norm();
  double t = from;
  for (int i = 0; i < kFewIterations; ++i) {
    const Separation now = shape.separation(p + t * motion);
    const double slope = now.normal.dot(motion);
    const double slope_error = normal_error(now) * length;
    const double gap = now.distance - level;
    if (slope - slope_error >= 0.0) return false;
    if (gap <= tolerance && slope + slope_error < 0.0) return true;
    if (gap <= tolerance) break;
    t += gap / (slope_error - slope);
    if (!(t <= until)) return false;
  }
  return comes_nearer(shape, p, motion, from, until, level, tolerance);
}

// When the motion from p must stop before a triangle, as t in [0, until], or kNever if it may go on up to `until`. It must stop where the
// distance reaches clearance.offset (in contact: offset - slop / 2), but only if it would later come nearer than offset - slop: grazing
// within the slop passes. The two tangents of the convex distance, at the ends, decide most triangles. start: the separation at p.
template <class Shape>
double time_to_block(const Shape& shape, const Vec3& p, const Separation& start, const Vec3& motion, double until,
                     const Clearance& clearance) {
  const double min_distance = clearance.offset - clearance.slop;
  const double length = motion.norm();
  const double start_slope = start.normal.dot(motion) - normal_error(start) * length;  // at its steepest
  if (start_slope >= 0.0 || start.distance + start_slope * until >= min_distance) return kNever;
  const Separation end = shape.separation(p + until * motion);
  const double end_slope = end.normal.dot(motion) + normal_error(end) * length;
  if (end.distance >= min_distance) {
    if (end_slope <= 0.0) return kNever;
    const double cross = (end.distance - end_slope * until - start.distance) / (start_slope - end_slope);
    if (start.distance + start_slope * cross >= min_distance) return kNever;
  }
  // From outside, the motion stops at the offset. In contact it may use up half of the slop, so that a long slide whose direction has a
  // rounding error still advances; the contact planes lift it again.
  const double half = clearance.offset - 0.5 * clearance.slop;
  double stop = 0.0;
  if (start.distance > clearance.offset + clearance.tolerance) {
    const double earliest = (start.distance - clearance.offset) / -start_slope;
    stop = time_to_reach(shape, p, motion, earliest, clearance.offset, clearance.tolerance);
  } else if (start.distance > half + clearance.tolerance) {
    stop = time_to_reach(shape, p, motion, 0.0, half, clearance.tolerance);
  }
  if (stop > until) return kNever;
  // A proxy at the lower bound may be below it by rounding. That alone does not stop it.
  const double level = start.distance >= min_distance - 64.0 * clearance.tolerance ? std::min(min_distance, start.distance) : min_distance;
  if (start.distance < level || end.distance < level) return stop;
  return dips_below(shape, p, motion, stop, until, level, clearance.tolerance) ? stop : kNever;
}

template <class Shape>
double time_to_block(const Shape& shape, const Vec3& p, const Vec3& motion, double until, const Clearance& clearance) {
  return time_to_block(shape, p, shape.separation(p), motion, until, clearance);
}

// The separation from a triangle that blocks `motion` at p: usually the separation at p. But a point probe just before a shallow concave
// edge first comes within rounding of that edge, whose normal is neither face's. Where the motion would continue over the face, the face is
// the constraint.
template <class Shape>
Separation blocking_separation(const Shape& shape, const Vec3& p, const Vec3& motion, const Clearance& clearance) {
  const Separation here = shape.separation(p);
  if (here.feature == Feature::face) return here;
  const double min_distance = clearance.offset - clearance.slop;
  const double t = here.distance > min_distance ? time_to_reach(shape, p, motion, 0.0, min_distance, clearance.tolerance) : kNever;
  if (t > 1.0) return here;
  Separation ahead = shape.separation(p + t * motion);
  if (ahead.feature != Feature::face) return here;
  ahead.distance -= t * ahead.normal.dot(motion);  // the plane's height under p
  ahead.nearest = p - ahead.distance * ahead.normal;
  return ahead;
}

}  // namespace hapton
