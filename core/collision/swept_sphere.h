#pragma once

#include "core/collision/touch_geometry.h"

namespace hapton {

// The distance a probe keeps from surfaces, and how exactly.
// A point probe is a sphere of radius `rest` = hover alone; a sphere probe adds its radius. All in metres.
struct Clearance {
  double rest = 0.0;   // a proxy in contact stands this far off
  double slack = 0.0;  // it is never nearer than rest - slack; rest - slack > 0, so no surface is ever crossed
};

// When a sphere that moves from p along `motion` comes to distance `level` of a triangle: t in [from, 1], or a value > 1 for never.
// The distance to a convex set along a line is convex, so Newton's tangent from the approaching side never oversteps the true
// root and converges quadratically: no feature cases, no cancelling discriminant, conservative at every iterate.
// Pre: distance at `from` is at least level. RT: yes.
inline double time_to_reach(const TouchGeometry& geometry, std::uint32_t triangle, const Vec3& p, const Vec3& motion, double from, double level,
                            double tolerance) {
  constexpr int kMaxIterations = 48;  // quadratic convergence needs under ten; the bound only limits time
  constexpr double kNever = 2.0;
  double t = from;
  for (int i = 0; i < kMaxIterations; ++i) {
    const Separation now = geometry.separation(triangle, p + t * motion);
    const double slope = now.normal.dot(motion);
    const double gap = now.distance - level;
    if (gap <= tolerance) return slope < 0.0 ? t : kNever;
    if (slope >= 0.0) return kNever;
    t += gap / -slope;
    if (!(t <= 1.0)) return kNever;
  }
  return t;
}

// When the motion from p must stop before a triangle, as t in [0, 1], or > 1 where it may pass. It must stop where the
// distance reaches clearance.rest, but only if it would later come nearer than rest - slack: grazing within the slack passes.
inline double time_to_block(const TouchGeometry& geometry, std::uint32_t triangle, const Vec3& p, const Vec3& motion, const Clearance& clearance) {
  const double tolerance = 0.25 * clearance.slack;
  const Separation start = geometry.separation(triangle, p);
  if (start.normal.dot(motion) >= 0.0) return 2.0;  // moving away from a convex set: never nearer again
  if (start.distance - motion.norm() > clearance.rest) return 2.0;
  double stop = 0.0;
  if (start.distance > clearance.rest + tolerance) {
    stop = time_to_reach(geometry, triangle, p, motion, 0.0, clearance.rest, tolerance);
    if (stop > 1.0) return stop;
  }
  const double low = clearance.rest - clearance.slack;
  if (start.distance <= low) return 0.0;
  return time_to_reach(geometry, triangle, p, motion, stop, low, tolerance) > 1.0 ? 2.0 : stop;
}

}  // namespace hapton
