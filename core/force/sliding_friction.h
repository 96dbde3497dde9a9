#pragma once

#include "core/math/types.h"

namespace hapton {

// A proxy under Coulomb friction on a plane, while the device moves straight at constant speed. The pull is the part of device - proxy in
// the plane; the friction cone's radius in the plane is the coefficient times the pressure.
struct FrictionMotion {
  Vec3 pull = Vec3::Zero();     // pull at the start
  Vec3 motion = Vec3::Zero();   // of the device, in the plane
  double pressure_start = 0.0;  // normal distance between proxy and device: the normal force divided by the stiffness; > 0
  double pressure_end = 0.0;    // > 0; the pressure changes linearly from start to end
  double friction_static = 0.0;
  double friction_dynamic = 0.0;  // <= friction_static
  bool sliding = false;           // at the start; true: the dynamic coefficient applies

  // A sliding proxy sticks again when its pull has fallen to this share of the dynamic cone's radius. Above that the proxy may stop and
  // then slide on, so it does not stick at every small concave edge. 0.5 is a choice, not a derivation; the reference uses the same value.
  static constexpr double kRestick = 0.5;
};

struct FrictionDrag {
  Vec3 pull = Vec3::Zero();  // at the end
  bool sliding = false;      // at the end
};

// The pull of a proxy that slides throughout a motion, in closed form. Time runs from 0 to 1; the cone's radius is radius + time * growth.
// The pull turns towards the motion and never past it. RT: yes.
class SlidingPull {
 public:
  // Pre: pull and motion are in one plane; radius > 0; |pull| = radius up to rounding; the proxy slides: pull . motion >= |pull| growth.
  SlidingPull(const Vec3& pull, const Vec3& motion, double radius, double growth) noexcept;

  Vec3 at(double time) const noexcept;
  // Speed of the proxy along its pull, as a length per whole motion.
  double speed_at(double time) const noexcept;
  // The time at which the pull is perpendicular to `normal`, a vector in the plane. Infinite: at no time >= 0.
  double time_across(const Vec3& normal) const noexcept;

 private:
  double tangent_at(double time) const noexcept;  // tangent of half the angle between pull and motion

  Vec3 ahead_ = Vec3::Zero();     // unit, along the motion
  Vec3 sideways_ = Vec3::Zero();  // unit, perpendicular to ahead_ on the pull's side; zero if the pull is along the motion
  double distance_ = 0.0;
  double radius_ = 0.0;
  double growth_ = 0.0;
  double tangent_ = 0.0;  // tangent_at(0)
};

// Follows the proxy to the end of the motion, in closed form. The proxy sticks until the pull leaves the static cone; it then jumps to the
// dynamic cone and is dragged along its pull, whose length stays the cone's radius. The proxy's path is the tractrix: with the angle psi
// between pull and motion and the cone's radius R, R psi' = -|motion| sin psi, so tan(psi / 2) falls by the factor exp(-integral of
// |motion| / R). Where the cone grows faster than the pull, the proxy stops, until the pull is on the cone again, or until it is shorter
// than kRestick of the radius: then the proxy sticks. This is the limit of ever finer steps of return mapping (the play operator in the
// plane). All lengths in one unit; only their ratios matter. RT: yes. Source: Visintin, Differential Models of Hysteresis (1994), III.2,
// vector play; the tractrix with a linear radius is ours.
FrictionDrag drag_by_friction(const FrictionMotion& input) noexcept;

}  // namespace hapton
