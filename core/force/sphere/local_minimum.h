#pragma once

#include "core/force/sphere/contact_set.h"

namespace hapton {

// The local minimum of a centre's distance to the device on all active contacts: the position on one plane, cylinder or sphere, in closed
// form; on the curve where two of them meet, by Newton's method; or where three of them meet. Here is where it lies, how fast it moves with
// the device, and how close it is to vanishing. A view of the contacts, which outlive it. `c`: the centre.
//
// Frame and units: TouchGeometry's local ones. RT: yes. `work`: is raised by the units of work (step_work.h). Pre: one to three active
// contacts.
class LocalMinimum {
 public:
  static constexpr double kAtMinimum = 0x1p-40;     // shorter tangential pulls count as a local minimum: the slop
  static constexpr double kTurn = 0.125;            // rad, in one piece of path: a cubic is then off by 6e-7 of the offset (CentrePath)
  static constexpr double kMinStability = 0x1p-26;  // below it the minimum along a curve counts as vanished
  static constexpr double kAtAxis = 0x1p-39;     // distance from the axis of an edge or a vertex below which a direction is mostly rounding
  static constexpr double kMinMotion = 0x1p-42;  // a shorter displacement counts as none

  explicit LocalMinimum(const ContactSet& contacts) : contacts_(contacts) {}

  // The minimum for the device. `c`: in, near it; out, exact to rounding, or along a curve to 2^-26 offsets. False: there is none near c.
  bool solve(const Vec3& device, Vec3& c, int& work) const noexcept;
  // Its velocity for a device that moves. Pre: at most two active contacts.
  Vec3 find_rate(const Vec3& c, const Vec3& device, const Vec3& motion) const noexcept;
  // Second derivative of half the squared distance to the device along the free directions, the least of all. 1: all active parts are flat.
  double find_stability(const Vec3& c, const Vec3& device) const noexcept;
  // The same, with the contacts' frame at c.
  double find_stability(const ContactFrame& frame, const Vec3& c, const Vec3& device) const noexcept;

  // The angle by which a displacement turns the centre about the active edges and vertices, rad.
  double find_turn(const Vec3& displacement) const noexcept;
  // Of two contacts: the length of a piece of their curve that turns by kTurn: about an edge or a vertex, or in its direction, which two
  // surfaces at a small angle turn faster. `direction`: unit, along the curve.
  double longest_on_curve(const ContactFrame& frame, const Vec3& direction) const noexcept;

  // Whether the device is on the axis of the only active contact, an edge or a vertex: then all positions around it are equally near.
  bool is_on_axis(const Vec3& device) const noexcept;
  // The first time after `time` at which the device is so far off that axis that its direction counts; 1: not before the end.
  double time_off_axis(const Vec3& from, const Vec3& to, double time) const noexcept;

  // Whether a barrier as low as the reference's contact offset is all that holds the centre; `direction`: unit, over it.
  bool is_shallow(const Vec3& c, const Vec3& device, Vec3& direction) const noexcept;

 private:
  bool solve_on_curve(const Vec3& device, Vec3& c, int& work) const noexcept;

  const ContactSet& contacts_;
};

// At a minimum: activates further contacts that the minimum's velocity would lead into.
void activate_opposing(ContactSet& contacts, const Vec3& c, const Vec3& device, const Vec3& motion) noexcept;

}  // namespace hapton
