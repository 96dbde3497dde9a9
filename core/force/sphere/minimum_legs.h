#pragma once

#include "core/force/sphere/local_minimum.h"

namespace hapton {

// A piece of the path of a sphere's centre while the device moves.
struct MinimumLeg {
  CentrePath path;
  double time = 1.0;         // of the device, when the centre reaches the end of the path
  int released = -1;         // the active contact whose multiplier is zero at the end; -1: none
  bool is_on_curve = false;  // the path is parametrised by length; time_on_curve() gives the device's time for a point of it
  bool vanishes = false;     // the minimum vanishes at the end
};

// The legs of a centre that stays the local minimum on its one or two active contacts while the device moves straight from `from` (time 0)
// to `to` (time 1). A leg ends when the device arrives, when a multiplier reaches zero, or when the minimum along a curve vanishes. It may
// end earlier, because it turns by at most about twice LocalMinimum::kTurn. A view: contacts, centre and `work` outlive this object. `work`
// is raised by the units of work used (step_work.h).
//
// Frame and units: TouchGeometry's local ones. RT: yes.
class MinimumLegs {
 public:
  MinimumLegs(const ContactSet& contacts, const Vec3& centre, int& work)
      : contacts_(contacts), minimum_(contacts), centre_(centre), work_(work) {}

  // The leg that begins at `time`. False: the minimum vanishes at `time`, or moves too fast to follow; `leg` is then undefined.
  bool make(const Vec3& from, const Vec3& to, double time, MinimumLeg& leg) const noexcept;
  // On a curve: the device's time at which the centre is the minimum. 0: the contacts are parallel, or the device moves across the curve.
  double time_on_curve(const Vec3& from, const Vec3& to) const noexcept;

 private:
  // Finds the leg along the curve where two contacts meet.
  class CurveSearch;

  void make_on_axis(const Vec3& from, const Vec3& to, double time, MinimumLeg& leg) const noexcept;
  bool end_at_release(const Vec3& from, const Vec3& to, double time, MinimumLeg& leg, Vec3& end) const noexcept;

  const ContactSet& contacts_;
  LocalMinimum minimum_;
  const Vec3& centre_;
  int& work_;
};

}  // namespace hapton
