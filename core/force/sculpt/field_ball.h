#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/math/types.h"
#include "core/sculpt/carved_field.h"

namespace hapton {

// A ball that moves on the surface of a field. It is represented by points on its sphere; its clearance is the least value of the field at
// these and at its centre. To compare the value at the centre with the radius would be wrong: after carves the zero set of a field is
// exact, but values off the surface are only lower bounds of the distance. Units: m. Frame: that of the field. RT: yes, except
// construction. Threads: any.
class FieldBall {
 public:
  // spacing_m: the spacing of the field's nodes. The points are about as far apart, but there are at most kMaxPoints.
  FieldBall(double radius_m, double spacing_m);

  // The least value of the field at the points and the centre, m; below 0: the ball overlaps the material. No point can reach material by a
  // motion shorter than this divided by kSteepest.
  double clearance_m(const CarvedField& field, const Vec3& centre) const noexcept;

  // Largest slope of a field, sqrt(3): values at adjacent nodes differ by a spacing at most, and a field is linear along each axis.
  static constexpr double kSteepest = 1.7320508075688772;

  // Moves the centre from `from` towards `goal`, and along the surface, to a position locally nearest to the goal, unless the work limit
  // ends the search before. A step in free space is no longer than the clearance, one along the surface a fraction of a spacing, so the
  // ball passes through no wall. Pre: clearance_m(from) >= 0 up to rounding; a ball that overlaps the material leaves it first.
  struct Moved {
    Vec3 centre = Vec3::Zero();
    Vec3 normal = Vec3::Zero();  // of the contact, unit, out of the material; zero: there is none
    bool touches = false;        // the goal was not reached
  };
  Moved move(const CarvedField& field, const Vec3& from, const Vec3& goal) const noexcept;

  // The farthest position on the straight path to the goal, found by at most 32 steps that keep the clearance at `least_m` or let it grow.
  Vec3 advance(const CarvedField& field, const Vec3& from, const Vec3& goal, double least_m) const noexcept;

  static constexpr std::size_t kMaxPoints = 240;  // bounds the time of a step; with the centre, their numbers fit into 8 bits

 private:
  static constexpr std::size_t kMaxPlanes = 12;  // most planes that constrain a step; three of them can be active
  // The points that can be near the surface while the centre is within valid_radius_m of `centre`; valid_radius_m < 0: none were chosen.
  struct Candidates {
    std::array<std::uint8_t, kMaxPoints + 1> points;
    std::size_t count = 0;
    Vec3 centre = Vec3::Zero();
    double valid_radius_m = -1.0;
  };
  struct NearPoint {
    std::size_t point = 0;
    double value = 0.0;
  };
  // The points with the smallest values, in ascending order: those with less than half a spacing, at most kMaxPlanes.
  struct Nearest {
    std::array<NearPoint, kMaxPlanes> points;
    std::size_t count = 0;
    double clearance_m = 0.0;  // of the ball, or a lower bound
  };
  Nearest find_nearest(const CarvedField& field, const Vec3& centre, Candidates& candidates) const noexcept;
  static void insert(Nearest& nearest, const NearPoint& one) noexcept;
  Vec3 slide(const CarvedField& field, const Vec3& centre, const Vec3& to_goal, const Nearest& nearest, Moved& moved) const noexcept;

  std::vector<Vec3> points_;  // relative to the centre; the last one is the centre itself
};

}  // namespace hapton
