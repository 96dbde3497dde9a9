#pragma once

#include <array>

#include "core/geometry/contact_triangle.h"

namespace hapton {

// A short piece of the way of a sphere's centre over an offset surface: a cubic with the true ends and tangents, time 0 to 1. Over an arc
// of a radius r that turns by an angle a it is r a^4 / 384 off. RT: yes.
class CentrePath {
 public:
  // A sphere may come so near before a triangle stops it, and it stops where it is just in contact. Between, what grazes passes.
  struct Keep {
    double offset = 0.0;     // the distance of a contact
    double slop = 0.0;       // less by this is never reached; half of it may be used up by what only grazes
    double tolerance = 0.0;  // of distances
  };
  static constexpr double kNever = 2.0;

  CentrePath() = default;
  static CentrePath straight(const Vec3& from, const Vec3& to) noexcept;
  static CentrePath curved(const Vec3& from, const Vec3& to, const Vec3& slope_from, const Vec3& slope_to) noexcept;

  const Vec3& start() const { return start_; }
  const Vec3& end() const { return end_; }
  Vec3 at(double time) const noexcept;
  Vec3 slope(double time) const noexcept;
  // No point of the path is farther from the chord.
  double bulge() const { return 0.125 * bend_; }
  bool is_straight() const { return bend_ == 0.0; }

  // The first time in [0, until] at which direction . (p - origin) exceeds zero on its way up, or kNever.
  double time_to_pass(const Vec3& origin, const Vec3& direction, double margin, double until) const noexcept;

  // When a triangle stops the centre, in [0, until], or kNever. The distance to a triangle is convex, so along the path it stays above the
  // parabola that it begins with, less what the path bends: every step of the search is safe, and near the hit it is Newton's.
  double time_to_block(const ContactTriangle& triangle, const Keep& keep, double until, int& tests) const noexcept;

 private:
  double time_below(const ContactTriangle& triangle, double level, double tolerance, double until, int& tests) const noexcept;

  Vec3 start_ = Vec3::Zero();
  Vec3 end_ = Vec3::Zero();
  std::array<Vec3, 3> rate_;  // start + rate 0 t + rate 1 t^2 + rate 2 t^3
  double bend_ = 0.0;         // the most of the second derivative
};

}  // namespace hapton
