#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/math/types.h"
#include "core/sculpt/carved_field.h"

namespace hapton {

// A ball on the surface of a field, as points on the ball: its clearance is the least value of the field at them and at its centre. The
// zero set of a field is exact after carves, its values off the surface are only bounds; so a ball is not the surface "value = radius".
// Units: m. Frame: that of the field. RT: all but construction. Threads: const calls from any number.
class FieldBall {
 public:
  // So many points that they are about a spacing apart, kMostPoints at most.
  FieldBall(double radius_m, double spacing_m);

  double radius_m() const noexcept { return radius_m_; }

  // No material is nearer to the ball than this (as the points see it) divided by kSteepest.
  double clearance_m(const CarvedField& field, const Vec3& centre) const noexcept;

  // Values at the nodes differ by a spacing at most between neighbours, so a field that is linear along each axis is no steeper than this.
  static constexpr double kSteepest = 1.7320508075688772;

  // Moves the centre from `from` towards `goal` as far as the material allows, and along it: to the nearest place, by bounded steps. A step
  // in free space is no longer than the clearance there, one along the surface a fraction of a spacing, and both end where nothing is
  // passed. Pre: clearance_m(from) is about 0 or more.
  struct Moved {
    Vec3 centre = Vec3::Zero();
    Vec3 normal = Vec3::Zero();  // of the contact: towards the centre, unit; zero: free
    bool touches = false;        // the goal was not reached
  };
  Moved move(const CarvedField& field, const Vec3& from, const Vec3& goal) const noexcept;

  // As far along the straight path as the clearance stays above `least_m`, or grows.
  Vec3 advance(const CarvedField& field, const Vec3& from, const Vec3& goal, double least_m) const noexcept;

  static constexpr std::size_t kMostPoints = 240;

 private:
  static constexpr std::size_t kMostPlanes = 12;
  // The points that can be near while the centre is within `room_m` of where they were chosen.
  struct Candidates {
    std::array<std::uint8_t, kMostPoints + 1> points;
    std::size_t count = 0;
    Vec3 centre = Vec3::Zero();
    double room_m = -1.0;
  };
  struct Near {
    std::size_t point = 0;
    double value = 0.0;
  };
  // The nearest points below `below_m`, at most kMostPlanes.
  struct Nearest {
    std::array<Near, kMostPlanes> points;
    std::size_t count = 0;
    double clearance_m = 0.0;
  };
  Nearest find_nearest(const CarvedField& field, const Vec3& centre, Candidates& candidates) const noexcept;
  static void insert(Nearest& nearest, const Near& one) noexcept;
  Vec3 slide(const CarvedField& field, const Vec3& centre, const Vec3& to_goal, const Nearest& nearest, Moved& moved) const noexcept;

  double radius_m_;
  std::vector<Vec3> points_;  // off the centre; the last one is the centre
};

}  // namespace hapton
