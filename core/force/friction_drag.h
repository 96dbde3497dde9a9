#pragma once

#include "core/math/types.h"

namespace hapton {

// A proxy held on a plane by Coulomb friction while the device moves straight at constant speed.
struct FrictionMotion {
  Vec3 lag = Vec3::Zero();      // device minus proxy at the start, in the plane
  Vec3 motion = Vec3::Zero();   // of the device, in the plane
  double pressure_start = 0.0;  // normal distance between proxy and device: the normal force without its stiffness; > 0
  double pressure_end = 0.0;    // > 0; it changes linearly on the way
  double friction_static = 0.0;
  double friction_dynamic = 0.0;  // <= friction_static
  bool sliding = false;           // at the start: the dynamic coefficient is in force

  // A proxy that slides sticks again once its lag has fallen to this share of the dynamic cone. Until then it may stop and slide on: over
  // small folds it does not stick.
  static constexpr double kRest = 0.5;
};

struct FrictionDrag {
  Vec3 lag = Vec3::Zero();  // device minus proxy at the end, in the plane
  bool sliding = false;     // at the end
};

// The lag of a proxy that slides throughout a motion, in closed form. Time runs from 0 to 1 over the motion; the cone's radius is
// `radius` + time * `growth`. The lag's direction turns towards the motion and never past it. RT: yes.
class SlidingLag {
 public:
  // lag, motion: in one plane. Pre: radius > 0; it slides: lag.motion >= |lag| growth; |lag| = radius but for rounding.
  SlidingLag(const Vec3& lag, const Vec3& motion, double radius, double growth) noexcept;

  Vec3 at(double time) const noexcept;
  // How fast the proxy goes along its lag then.
  double speed_at(double time) const noexcept;
  // When the lag lies across `normal`, a vector in the plane; infinite: never from 0 on.
  double time_across(const Vec3& normal) const noexcept;

 private:
  double tangent_at(double time) const noexcept;  // of half the angle to the motion

  Vec3 ahead_ = Vec3::Zero();     // unit, along the motion
  Vec3 sideways_ = Vec3::Zero();  // unit or zero: the lag is in the plane of both, on this side
  double way_ = 0.0;
  double radius_ = 0.0;
  double growth_ = 0.0;
  double tangent_ = 0.0;  // at the start
};

// Follows the proxy to the end of the motion, in closed form: it sticks until the lag leaves the static cone, jumps to the dynamic one, and
// is then dragged along its own lag, which keeps the cone's size. That path is the tractrix: with the angle psi between lag and motion and
// the cone's radius R, R psi' = -|motion| sin psi, so tan(psi / 2) falls by exp(-integral of |motion| / R). Where the lag would become
// shorter than the cone is wide it stays, until it is on the cone again or, at kRest of it, sticks. This is the limit of ever finer steps
// of return mapping (the play operator in the plane). All lengths in one unit; only their ratios matter. RT: yes. Source: Visintin,
// Differential Models of Hysteresis (1994), III.2, vector play; the tractrix with a linear radius is ours.
FrictionDrag drag_by_friction(const FrictionMotion& input) noexcept;

}  // namespace hapton
