#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "core/collision/swept_sphere.h"
#include "core/geometry/contact_triangle.h"

namespace hapton {

// A short piece of the path of a sphere's centre over an offset surface: a cubic with the true ends and tangents, time 0 to 1, projected
// onto the one or two parts of that surface that guide it. For an arc of radius r and angle a the error of the cubic is r a^4 / 384.
// Frame and units: the caller's. RT: yes.
class CentrePath {
 public:
  // The surface at the distance `offset` from the plane, line or point that carries a part of a triangle: a plane, a cylinder or a sphere.
  struct Guide {
    Feature part = Feature::face;
    Vec3 origin = Vec3::Zero();
    Vec3 direction = Vec3::Zero();  // unit: the plane's normal, towards the centre; the line's direction
    double offset = 0.0;
    // Distance from the plane, line or point; `normal`: its gradient, zero on the line or at the point itself.
    double distance_to(const Vec3& p, Vec3& normal) const noexcept;
  };
  CentrePath() = default;
  static CentrePath straight(const Vec3& from, const Vec3& to) noexcept;
  static CentrePath curved(const Vec3& from, const Vec3& to, const Vec3& slope_from, const Vec3& slope_to) noexcept;
  // Pre: at most two guides, not parallel along the path.
  void add_guide(const Guide& guide) { guides_[guide_count_++] = guide; }

  const Vec3& start() const { return start_; }
  const Vec3& end() const { return end_; }
  Vec3 at(double time) const noexcept;
  // The derivative by time: its direction is exact to rounding, its length within 2^-11 of itself.
  Vec3 slope(double time) const noexcept;
  // Upper bound of the distance between path and chord.
  double bulge() const { return 0.125 * bulge_bend_; }
  bool is_straight() const { return bend_ == 0.0; }
  bool is_guided() const { return guide_count_ > 0; }

  // The beginning of the path up to the time `until`, with the point and derivative at that time; computed once for many triangles.
  struct Prefix {
    double until = 1.0;
    Vec3 end = Vec3::Zero();
    Vec3 slope = Vec3::Zero();  // at `until`
  };
  Prefix prefix(double until) const noexcept;

  // The first time in [from, until] at which direction . (p - origin) rises above `margin`, or kNever.
  double time_to_cross(const Vec3& origin, const Vec3& direction, double margin, double from, double until) const noexcept;
  // The same from time 0 to the end of the prefix.
  double time_to_cross(const Vec3& origin, const Vec3& direction, double margin, const Prefix& prefix) const noexcept;

  // When a triangle stops the centre, in [0, until]: on contact, and only if the centre would later come nearer than offset - slop / 2. The
  // distance to a triangle is convex, so along the path it stays above one parabola through its start and one through its end, which allow
  // for the path's second derivative: most triangles need no search. Each step of a search is conservative, and near the hit a step of
  // Newton's method. A search ends after 64 steps. `tests`: raised by the number of distances computed. `guiding`: a bit for each corner
  // that belongs to a part that guides the path: such a corner is never nearer than the part.
  struct Block {
    double time = kNever;
    bool hits = false;  // false: the path is free up to `time` (kNever: all of it); the search found no more
  };
  Block find_block(const ContactTriangle& triangle, const Clearance& clearance, unsigned guiding, const Prefix& prefix,
                   int& tests) const noexcept;

 private:
  struct Level {
    double distance = 0.0;
    double tolerance = 0.0;
  };
  Block find_below(const ContactTriangle& triangle, const Level& level, unsigned guiding, double from, double until,
                   int& tests) const noexcept;
  double least_by_ends(const ContactTriangle& triangle, const Separation& start, double approach, const Prefix& prefix) const noexcept;
  struct Plane {
    Vec3 origin, direction;
    double margin;
    double height(const Vec3& p) const { return direction.dot(p - origin) - margin; }
  };
  struct Range {
    double low, high, at_low, at_high;  // times, and the heights then
  };
  double find_crossing(const Plane& plane, Range range) const noexcept;
  double guess_crossing(const Plane& plane, Range range) const noexcept;
  Vec3 cubic_at(double time) const { return start_ + time * (rate_[0] + time * (rate_[1] + time * rate_[2])); }
  double find_turning_point(const Vec3& direction, double low, double high) const noexcept;
  int find_guiding_corner(const ContactTriangle& triangle, unsigned guiding, const Vec3& nearest) const noexcept;
  double step_past_corner(const ContactTriangle& triangle, const Level& level, int corner, double time) const noexcept;
  // State of a search at one time: the centre, its velocity, and its separation from the triangle.
  struct Place {
    Vec3 point = Vec3::Zero();
    Vec3 velocity = Vec3::Zero();
    Separation separation;
    double approach = 0.0;  // lower bound of the derivative of the distance by time
  };
  double step_beside_guides(const ContactTriangle& triangle, const Level& level, const Place& here) const noexcept;
  double time_beside_line(const Guide& guide, const ContactTriangle& triangle, const Level& level, const Place& here) const noexcept;
  double time_beside(const Guide& guide, const Vec3& off, double sine, const Level& level, const Place& here) const noexcept;
  double time_within(const Vec3& origin, const Vec3& inwards, const Place& here) const noexcept;
  double time_on_edge(const ContactTriangle& triangle, int edge, const Place& here) const noexcept;
  double time_at_corner(const ContactTriangle& triangle, int corner, const Place& here) const noexcept;
  double time_to_leave_corner(const ContactTriangle& triangle, int corner, double from, double until) const noexcept;

  double bend_towards(const Vec3& normal) const { return std::fabs(normal.dot(chord_)) * bend_along_ + bend_across_; }
  void project_onto_guides(Vec3& p) const noexcept;
  double project_once(Vec3& p) const noexcept;
  Vec3 slope(double time, const Vec3& p) const noexcept;  // p: at that time
  Vec3 cubic_slope(double time) const { return rate_[0] + time * (2.0 * rate_[1] + 3.0 * time * rate_[2]); }

  Vec3 start_ = Vec3::Zero();
  Vec3 end_ = Vec3::Zero();
  std::array<Vec3, 3> rate_;   // start + rate 0 t + rate 1 t^2 + rate 2 t^3
  double bend_ = 0.0;          // upper bound of the second derivative,
  Vec3 chord_ = Vec3::Zero();  // unit
  double bend_along_ = 0.0;    // of its component along the chord (uneven speed),
  double bend_across_ = 0.0;   // and of its component across the chord
  double bulge_bend_ = 0.0;
  std::array<Guide, 2> guides_;
  int guide_count_ = 0;
};

}  // namespace hapton
