// Along the curve where two offset surfaces meet, by length: near the end of a minimum the centre moves ever faster, and a piece made by
// time would have to be ever shorter.
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/force/sphere/minimum_legs.h"
#include "core/math/find_zero.h"
#include "core/math/straight_motion.h"

namespace hapton {

// The place that far along the curve. It is the minimum when the device is level with it: a linear equation for the time. False: the curve
// turns too far, or does not lead there.
bool MinimumLegs::find_on_curve(const Course& course, double ahead, CurvePlace& place) const noexcept {
  const auto& [from, motion, direction, sense] = course;
  place.centre = centre_ + ahead * direction;
  if (!contacts_.restore_to_frame(place.centre, place.frame, work_)) return false;
  const Vec3 chord = place.centre - centre_;
  if (!(direction.dot(chord) > 0.5 * chord.norm())) return false;
  place.along = sense * place.frame.along;
  if (!(place.along.dot(direction) > 1.0 - 2.0 * LocalMinimum::kTurn * LocalMinimum::kTurn))
    return false;  // opposite: the curve on the other side of a crest
  const double pace = place.along.dot(motion);
  place.time = pace > 0.0 ? place.along.dot(place.centre - from) / pace : std::numeric_limits<double>::infinity();
  const Vec3 device = from + std::min(place.time, 1.0) * motion;
  place.stability = 1.0;
  for (int i = 0; i < 2; ++i) {
    place.stability -=
        std::max(0.0, place.frame.dual[i].dot(place.centre - device)) * contacts_[i].curvature(place.frame.along, contacts_.offset());
  }
  return true;
}

// The time at which the device makes this centre the minimum.
double MinimumLegs::time_on_curve(const Vec3& from, const Vec3& to) const noexcept {
  ContactFrame frame;
  if (!contacts_.find_frame(centre_, frame)) return 0.0;
  const double pace = frame.along.dot(to - from);
  return pace != 0.0 ? frame.along.dot(centre_ - from) / pace : 0.0;
}

// As far as a piece may turn, until the device arrives, or to where the minimum vanishes or a multiplier reaches zero. False: the device
// moves across the curve, or the curve is too sharp.
bool MinimumLegs::make_on_curve(const Vec3& from, const Vec3& to, double time, MinimumLeg& leg) const noexcept {
  constexpr int kMostHalvings = 8;        // then the curve is too sharp
  constexpr int kMostGrowing = 8;         // quarterings of the piece, to find where a new multiplier has risen
  constexpr double kLeastPace = 0x1p-10;  // of the device's speed, along the curve
  constexpr double kNearZero = 0x1p-30;   // of a share of what is left
  constexpr double kNearNone = 0x1p-50;   // rounding of a multiplier
  const Vec3 motion = to - from;
  ContactFrame here;
  if (!contacts_.find_frame(centre_, here)) return false;
  const double pace = here.along.dot(motion);
  if (!(std::fabs(pace) > kLeastPace * motion.norm())) return false;
  const double sense = pace < 0.0 ? -1.0 : 1.0;
  const Vec3 direction = sense * here.along;
  const Course course{from, motion, direction, sense};
  if (!(minimum_.find_stability(here, centre_, on_path(from, to, time)) > LocalMinimum::kLeastStability)) return false;

  CurvePlace end;
  const auto left = [&](const CurvePlace& place) { return (1.0 - place.time) / (1.0 - time); };
  const auto room = [&](const CurvePlace& place) { return std::max(-1.0, std::min(place.stability, left(place))); };
  const auto room_at = [&](double ahead) {
    return find_on_curve(course, ahead, end) ? room(end) : std::numeric_limits<double>::quiet_NaN();
  };
  double length = minimum_.longest_on_curve(here, direction);
  bool is_found = false;
  for (int i = 0; i < kMostHalvings && !is_found; ++i, length *= is_found ? 1.0 : 0.5) {
    CurvePlace middle;
    if (!find_on_curve(course, 0.5 * length, middle) || !find_on_curve(course, length, end)) continue;
    if (!(room(middle) > 0.0)) continue;
    is_found = !(room(end) > 0.0) || (time < middle.time && middle.time < end.time);
  }
  if (!is_found) return false;
  if (!(room(end) > 0.0)) {
    length = find_zero(0.0, 1.0, length, room(end), kNearZero, room_at);
    if (!find_on_curve(course, length, end)) return false;
    leg.vanishes = end.stability < left(end);
    if (!leg.vanishes && minimum_.solve(to, end.centre, work_) && contacts_.find_frame(end.centre, end.frame)) {
      end.time = 1.0;
      end.along = sense * end.frame.along;
    }
  }
  leg.time = std::clamp(end.time, time, 1.0);

  leg.released = -1;
  for (int i = 0; i < 2; ++i) {
    const auto multiplier = [&](const CurvePlace& place) {
      return place.frame.dual[static_cast<std::size_t>(i)].dot(place.centre - on_path(from, to, place.time));
    };
    const double at_end = multiplier(end);
    if (!(at_end < -LocalMinimum::kAtMinimum)) continue;
    const auto multiplier_at = [&](double ahead) {
      return find_on_curve(course, ahead, end) ? multiplier(end) : std::numeric_limits<double>::quiet_NaN();
    };
    double begin = 0.0;
    double at_begin = std::max(0.0, here.dual[static_cast<std::size_t>(i)].dot(centre_ - on_path(from, to, time)));
    // The multiplier of a new contact begins at zero, and may rise before it falls to zero again.
    for (int k = 1; k <= kMostGrowing && at_begin <= LocalMinimum::kAtMinimum; ++k) {
      const double grown = multiplier_at(std::ldexp(length, -2 * k));
      if (!(grown > LocalMinimum::kAtMinimum)) continue;
      begin = std::ldexp(length, -2 * k);
      at_begin = grown;
    }
    length = find_zero(begin, at_begin, length, at_end, kNearNone, multiplier_at);
    leg.released = i;
    leg.vanishes = false;
    if (length > 0.0) {
      if (!find_on_curve(course, length, end)) return false;
      leg.time = std::clamp(end.time, time, 1.0);
    } else {
      end.centre = centre_;
      end.along = direction;
      leg.time = time;
    }
  }
  const double chord = (end.centre - centre_).norm();
  leg.is_on_curve = true;
  leg.path = chord > 0.0 ? CentrePath::curved(centre_, end.centre, chord * direction, chord * end.along)
                         : CentrePath::straight(centre_, end.centre);
  if (chord > 0.0) contacts_.guide(leg.path);
  return true;
}

}  // namespace hapton
