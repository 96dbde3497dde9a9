#pragma once

#include "core/force/sphere/contact_set.h"

namespace hapton {

// The local minimum of a centre's distance to the device where all active contacts hold: on the surface of one (plane, cylinder or sphere),
// in closed form; on the curve where two of them meet, by Newton's method; or at the point where three meet. Finds where it lies, how fast
// it moves with the device, and how close it is to vanishing. A view of the contacts, which outlive it. `c`: the centre.
//
// Frame and units: TouchGeometry's local ones. RT: yes. `work`: is raised by the units of work (step_work.h). Pre: one to three active
// contacts.
class LocalMinimum {
 public:
  static constexpr double kAtMinimum = 0x1p-40;     // local units, the slop: with a shorter tangential pull a centre is at its minimum
  static constexpr double kTurn = 0.125;            // rad, in one piece of path: a cubic then has an error of 6e-7 offsets (CentrePath)
  static constexpr double kMinStability = 0x1p-26;  // below it the minimum along a curve counts as vanished
  static constexpr double kAtAxis = 0x1p-39;        // local units; nearer to an edge or a vertex, a direction from it is mostly rounding
  static constexpr double kMinMotion = 0x1p-42;     // local units: a shorter displacement counts as none

  explicit LocalMinimum(const ContactSet& contacts) : contacts_(contacts) {}

  // `c`: in, near the minimum; out, at it to rounding, along a curve to 2^-26 offsets; with three contacts, as it was. False: none near.
  bool solve(const Vec3& device, Vec3& c, int& work) const noexcept;
  // The displacement of the minimum for a small displacement `motion` of the device, to first order. Pre: at most two active contacts.
  Vec3 find_rate(const Vec3& c, const Vec3& device, const Vec3& motion) const noexcept;
  // Least second derivative of half the squared distance to the device along at most two active contacts. 1: all flat, or no frame.
  double find_stability(const Vec3& c, const Vec3& device) const noexcept;
  // The same, with the contacts' frame at c.
  double find_stability(const ContactFrame& frame, const Vec3& c, const Vec3& device) const noexcept;

  // The angle by which a displacement turns the centre about the active edges and vertices, rad.
  double find_turn(const Vec3& displacement) const noexcept;
  // Of two contacts: the length of a piece of their curve that turns by kTurn, about an edge or a vertex, or in its direction, which
  // changes faster where two surfaces meet at a small angle. `direction`: unit, along the curve.
  double longest_on_curve(const ContactFrame& frame, const Vec3& direction) const noexcept;

  // Whether the device is on the edge's line or at the vertex of the only active contact: all positions around that are equally near.
  bool is_on_axis(const Vec3& device) const noexcept;
  // The first time after `time` at which the device, on its way from `from` to `to`, is 4 kAtAxis off that axis; 1: not before the end.
  double time_off_axis(const Vec3& from, const Vec3& to, double time) const noexcept;

  // Whether all that holds the centre is a barrier no higher than the reference's contact offset; `direction`: unit, over the barrier.
  bool is_shallow(const Vec3& c, const Vec3& device, Vec3& direction) const noexcept;

 private:
  bool solve_on_curve(const Vec3& device, Vec3& c, int& work) const noexcept;

  const ContactSet& contacts_;
};

// At a minimum: activates contacts into which the moving minimum would lead the centre; at most three are then active.
void activate_opposing(ContactSet& contacts, const Vec3& c, const Vec3& device, const Vec3& motion) noexcept;

}  // namespace hapton
