#pragma once

#include "core/force/sphere/local_minimum.h"

namespace hapton {

// A piece of a centre's path while the device moves.
struct MinimumLeg {
  CentrePath path;
  double time = 1.0;         // of the device at its end
  int released = -1;         // the contact whose multiplier is zero there; -1: none
  bool is_on_curve = false;  // parametrised by length; time of a point: when the device makes it the minimum
  bool vanishes = false;     // the minimum vanishes at its end
};

// The legs of a centre that stays the local minimum on its active contacts, one or two, while the device moves straight from `from` (time
// 0) to `to` (time 1): until the device arrives, or to where a multiplier reaches zero or the minimum along a curve vanishes. A leg turns
// by LocalMinimum::kTurn at the most, and may end before all that. A view: contacts, centre and `work`, which is raised by the units of
// work (step_work.h), outlive it.
//
// Frame and units: TouchGeometry's local ones. RT: yes.
class MinimumLegs {
 public:
  MinimumLegs(const ContactSet& contacts, const Vec3& centre, int& work)
      : contacts_(contacts), minimum_(contacts), centre_(centre), work_(work) {}

  // The leg that begins at `time`. False: the minimum vanishes here, or moves too fast to follow.
  bool make(const Vec3& from, const Vec3& to, double time, MinimumLeg& leg) const noexcept;
  // On a curve: the time at which the device makes the centre the minimum.
  double time_on_curve(const Vec3& from, const Vec3& to) const noexcept;

 private:
  // Along the curve where two contacts meet.
  class CurveSearch;

  void make_on_axis(const Vec3& from, const Vec3& to, double time, MinimumLeg& leg) const noexcept;
  bool end_at_release(const Vec3& from, const Vec3& to, double time, MinimumLeg& leg, Vec3& end) const noexcept;

  const ContactSet& contacts_;
  LocalMinimum minimum_;
  const Vec3& centre_;
  int& work_;
};

}  // namespace hapton
