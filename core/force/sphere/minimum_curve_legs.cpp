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
  place.stability = minimum_.find_stability(place.frame, place.centre, device);
  return true;
}

// The time at which the device makes this centre the minimum.
double MinimumLegs::time_on_curve(const Vec3& from, const Vec3& to) const noexcept {
  ContactFrame frame;
  if (!contacts_.find_frame(centre_, frame)) return 0.0;
  const double pace = frame.along.dot(to - from);
  return pace != 0.0 ? frame.along.dot(centre_ - from) / pace : 0.0;
}

// A piece of the curve, from the centre.
class MinimumLegs::CurveSearch {
 public:
  CurveSearch(const MinimumLegs& legs, const Vec3& from, const Vec3& to, double time) noexcept
      : legs_(legs), from_(from), to_(to), time_(time) {}

  bool make(MinimumLeg& leg) noexcept {
    if (!begin() || !find_length() || !end_where_it_vanishes(leg)) return false;
    leg.time = std::clamp(end_.time, time_, 1.0);
    leg.released = -1;
    for (int i = 0; i < 2; ++i) {
      if (!end_at_release(i, leg)) return false;
    }
    make_path(leg);
    return true;
  }

 private:
  // False: the device moves across the curve, or there is no minimum.
  bool begin() noexcept {
    constexpr double kMinPace = 0x1p-10;  // of the device's speed, along the curve
    const Vec3 motion = to_ - from_;
    if (!legs_.contacts_.find_frame(legs_.centre_, here_)) return false;
    const double pace = here_.along.dot(motion);
    if (!(std::fabs(pace) > kMinPace * motion.norm())) return false;
    const double sense = pace < 0.0 ? -1.0 : 1.0;
    course_ = {from_, motion, sense * here_.along, sense};
    return legs_.minimum_.find_stability(here_, legs_.centre_, on_path(from_, to_, time_)) > LocalMinimum::kMinStability;
  }

  bool go(double ahead) noexcept { return legs_.find_on_curve(course_, ahead, end_); }
  // `value` of the place that far ahead; NaN: the curve does not lead there.
  template <class Value>
  auto after(Value&& value) noexcept {
    return [this, value](double ahead) { return go(ahead) ? value(end_) : std::numeric_limits<double>::quiet_NaN(); };
  }

  double left(const CurvePlace& place) const noexcept { return (1.0 - place.time) / (1.0 - time_); }
  // Zero where the minimum vanishes or the device arrives.
  double room(const CurvePlace& place) const noexcept { return std::max(-1.0, std::min(place.stability, left(place))); }

  // As far as a piece may turn, less where the curve is not smooth enough. False: it is too sharp.
  bool find_length() noexcept {
    constexpr int kMaxHalvings = 8;
    length_ = legs_.minimum_.longest_on_curve(here_, course_.direction);
    for (int i = 0; i < kMaxHalvings; ++i, length_ *= 0.5) {
      CurvePlace middle;
      if (!legs_.find_on_curve(course_, 0.5 * length_, middle) || !go(length_)) continue;
      if (!(room(middle) > 0.0)) continue;
      if (!(room(end_) > 0.0) || (time_ < middle.time && middle.time < end_.time)) return true;
    }
    return false;
  }

  // Ends the piece earlier, or where the device arrives.
  bool end_where_it_vanishes(MinimumLeg& leg) noexcept {
    constexpr double kNearZero = 0x1p-30;  // of a share of what is left
    if (room(end_) > 0.0) return true;
    length_ = find_zero(0.0, 1.0, length_, room(end_), kNearZero, after([this](const CurvePlace& place) { return room(place); }));
    if (!go(length_)) return false;
    leg.vanishes = end_.stability < left(end_);
    if (!leg.vanishes && legs_.minimum_.solve(to_, end_.centre, legs_.work_) && legs_.contacts_.find_frame(end_.centre, end_.frame)) {
      end_.time = 1.0;
      end_.along = course_.sense * end_.frame.along;
    }
    return true;
  }

  // Where the multiplier of that contact reaches zero. False: the curve does not lead there.
  bool end_at_release(int contact, MinimumLeg& leg) noexcept {
    constexpr int kMaxGrowing = 8;         // quarterings of the piece, to find where a new multiplier has risen
    constexpr double kNearNone = 0x1p-50;  // rounding of a multiplier
    const auto multiplier = [&](const CurvePlace& place) {
      return place.frame.dual[contact].dot(place.centre - on_path(from_, to_, place.time));
    };
    const double at_end = multiplier(end_);
    if (!(at_end < -LocalMinimum::kAtMinimum)) return true;
    const auto multiplier_at = after(multiplier);
    double begin = 0.0;
    double at_begin = std::max(0.0, here_.dual[contact].dot(legs_.centre_ - on_path(from_, to_, time_)));
    // The multiplier of a new contact begins at zero, and may rise before it falls to zero again.
    for (int i = 1; i <= kMaxGrowing && at_begin <= LocalMinimum::kAtMinimum; ++i) {
      const double grown = multiplier_at(std::ldexp(length_, -2 * i));
      if (!(grown > LocalMinimum::kAtMinimum)) continue;
      begin = std::ldexp(length_, -2 * i);
      at_begin = grown;
    }
    length_ = find_zero(begin, at_begin, length_, at_end, kNearNone, multiplier_at);
    leg.released = contact;
    leg.vanishes = false;
    if (length_ > 0.0) {
      if (!go(length_)) return false;
      leg.time = std::clamp(end_.time, time_, 1.0);
    } else {
      end_.centre = legs_.centre_;
      end_.along = course_.direction;
      leg.time = time_;
    }
    return true;
  }

  void make_path(MinimumLeg& leg) const noexcept {
    const Vec3& centre = legs_.centre_;
    const double chord = (end_.centre - centre).norm();
    leg.is_on_curve = true;
    leg.path = chord > 0.0 ? CentrePath::curved(centre, end_.centre, chord * course_.direction, chord * end_.along)
                           : CentrePath::straight(centre, end_.centre);
    if (chord > 0.0) legs_.contacts_.guide(leg.path);
  }

  const MinimumLegs& legs_;
  const Vec3& from_;
  const Vec3& to_;
  const double time_;  // where the piece begins
  ContactFrame here_;  // there
  Course course_;
  double length_ = 0.0;
  CurvePlace end_;
};

// Until the device arrives, or to where the minimum vanishes or a multiplier reaches zero. False: the device moves across the curve, or the
// curve is too sharp.
bool MinimumLegs::make_on_curve(const Vec3& from, const Vec3& to, double time, MinimumLeg& leg) const noexcept {
  return CurveSearch(*this, from, to, time).make(leg);
}

}  // namespace hapton
