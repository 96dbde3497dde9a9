#include "core/force/sphere/minimum_legs.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/math/find_zero.h"
#include "core/math/straight_motion.h"

namespace hapton {
namespace {

constexpr double kAtMinimum = LocalMinimum::kAtMinimum;

// Finds when a multiplier reaches zero. It is `at_begin` at the start, and negative at the end. The multiplier of a new contact starts at
// zero, and may rise before it falls to zero again.
template <class Value>
double find_release(double begin, double at_begin, double end, double at_end, Value&& multiplier) {
  constexpr int kMaxGrowing = 8;         // quarterings of the leg, to find where a new multiplier has risen
  constexpr double kNearZero = 0x1p-50;  // rounding of a multiplier
  double low = begin;
  for (int k = 1; k <= kMaxGrowing && at_begin <= kAtMinimum; ++k) {
    const double then = begin + std::ldexp(end - begin, -2 * k);
    const double grown = multiplier(then);
    if (!(grown > kAtMinimum)) continue;
    low = then;
    at_begin = grown;
  }
  return find_zero(low, at_begin, end, at_end, kNearZero, multiplier);
}

}  // namespace

double MinimumLegs::time_on_curve(const Vec3& from, const Vec3& to) const noexcept {
  ContactFrame frame;
  if (!contacts_.find_frame(centre_, frame)) return 0.0;
  const double pace = frame.along.dot(to - from);
  return pace != 0.0 ? frame.along.dot(centre_ - from) / pace : 0.0;
}

// Finds a piece of the curve where two offset surfaces meet, by its length: near the end of a minimum the centre moves ever faster, and
// pieces by time would have to be ever shorter. The piece ends when the device arrives, the minimum vanishes or a multiplier reaches zero.
class MinimumLegs::CurveSearch {
 public:
  CurveSearch(const MinimumLegs& legs, const Vec3& from, const Vec3& to, double time) noexcept
      : legs_(legs), from_(from), to_(to), time_(time) {}

  // False: the device moves across the curve, or the curve is too sharp.
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
  struct Place {
    Vec3 centre = Vec3::Zero();
    ContactFrame frame;
    Vec3 along = Vec3::Zero();  // unit, in the direction of travel
    double time = 0.0;          // the time at which this is the minimum for the device
    double stability = 0.0;     // the stability of that minimum
  };

  // False: the device moves across the curve, or there is no minimum.
  bool begin() noexcept {
    constexpr double kMinPace = 0x1p-10;  // share of the device's speed that must be along the curve
    if (!legs_.contacts_.find_frame(legs_.centre_, start_frame_)) return false;
    const double pace = start_frame_.along.dot(motion_);
    if (!(std::fabs(pace) > kMinPace * motion_.norm())) return false;
    sense_ = pace < 0.0 ? -1.0 : 1.0;
    direction_ = sense_ * start_frame_.along;
    return legs_.minimum_.find_stability(start_frame_, legs_.centre_, on_path(from_, to_, time_)) > LocalMinimum::kMinStability;
  }

  // Finds the place at the distance `ahead` along the curve. It is the minimum when the device crosses the plane normal to the curve there:
  // a linear equation for the time. False: the curve turns too far, or does not lead there.
  bool find(double ahead, Place& place) const noexcept {
    place.centre = legs_.centre_ + ahead * direction_;
    if (!legs_.contacts_.restore_to_frame(place.centre, place.frame, legs_.work_)) return false;
    const Vec3 chord = place.centre - legs_.centre_;
    if (!(direction_.dot(chord) > 0.5 * chord.norm())) return false;
    place.along = sense_ * place.frame.along;
    if (!(place.along.dot(direction_) > 1.0 - 2.0 * LocalMinimum::kTurn * LocalMinimum::kTurn))
      return false;  // turns too far, or is opposite: then it is the curve on the other side of a crest
    const double pace = place.along.dot(motion_);
    place.time = pace > 0.0 ? place.along.dot(place.centre - from_) / pace : std::numeric_limits<double>::infinity();
    const Vec3 device = from_ + std::min(place.time, 1.0) * motion_;
    place.stability = legs_.minimum_.find_stability(place.frame, place.centre, device);
    return true;
  }

  bool go(double ahead) noexcept { return find(ahead, end_); }
  // A function of the distance ahead: `value` of the place there; NaN: the curve does not lead there.
  template <class Value>
  auto after(Value&& value) noexcept {
    return [this, value](double ahead) { return go(ahead) ? value(end_) : std::numeric_limits<double>::quiet_NaN(); };
  }

  double time_left(const Place& place) const noexcept { return (1.0 - place.time) / (1.0 - time_); }
  // Zero where the minimum vanishes or the device arrives.
  double vanishing_margin(const Place& place) const noexcept { return std::max(-1.0, std::min(place.stability, time_left(place))); }

  // Sets the length: as far as a piece may turn, or less if the curve is not smooth enough. False: the curve is too sharp.
  bool find_length() noexcept {
    constexpr int kMaxHalvings = 8;
    length_ = legs_.minimum_.longest_on_curve(start_frame_, direction_);
    for (int i = 0; i < kMaxHalvings; ++i, length_ *= 0.5) {
      Place middle;
      if (!find(0.5 * length_, middle) || !go(length_)) continue;
      if (!(vanishing_margin(middle) > 0.0)) continue;
      if (!(vanishing_margin(end_) > 0.0) || (time_ < middle.time && middle.time < end_.time)) return true;
    }
    return false;
  }

  // If the minimum vanishes or the device arrives within the piece, ends the piece there. False: the curve does not lead there.
  bool end_where_it_vanishes(MinimumLeg& leg) noexcept {
    constexpr double kNearZero = 0x1p-30;  // rounding error of vanishing_margin()
    if (vanishing_margin(end_) > 0.0) return true;
    length_ = find_zero(0.0, 1.0, length_, vanishing_margin(end_), kNearZero,
                        after([this](const Place& place) { return vanishing_margin(place); }));
    if (!go(length_)) return false;
    leg.vanishes = end_.stability < time_left(end_);
    if (!leg.vanishes && legs_.minimum_.solve(to_, end_.centre, legs_.work_) && legs_.contacts_.find_frame(end_.centre, end_.frame)) {
      end_.time = 1.0;
      end_.along = sense_ * end_.frame.along;
    }
    return true;
  }

  // If the multiplier of this contact turns negative, ends the piece where it is zero. False: the curve does not lead there.
  bool end_at_release(int contact, MinimumLeg& leg) noexcept {
    const auto multiplier = [&](const Place& place) {
      return place.frame.dual[contact].dot(place.centre - on_path(from_, to_, place.time));
    };
    const double at_end = multiplier(end_);
    if (!(at_end < -LocalMinimum::kAtMinimum)) return true;
    const double at_begin = std::max(0.0, start_frame_.dual[contact].dot(legs_.centre_ - on_path(from_, to_, time_)));
    length_ = find_release(0.0, at_begin, length_, at_end, after(multiplier));
    leg.released = contact;
    leg.vanishes = false;
    if (length_ > 0.0) {
      if (!go(length_)) return false;
      leg.time = std::clamp(end_.time, time_, 1.0);
    } else {
      end_.centre = legs_.centre_;
      end_.along = direction_;
      leg.time = time_;
    }
    return true;
  }

  void make_path(MinimumLeg& leg) const noexcept {
    const Vec3& centre = legs_.centre_;
    const double chord = (end_.centre - centre).norm();
    leg.is_on_curve = true;
    leg.path = chord > 0.0 ? CentrePath::curved(centre, end_.centre, chord * direction_, chord * end_.along)
                           : CentrePath::straight(centre, end_.centre);
    if (chord > 0.0) legs_.contacts_.guide(leg.path);
  }

  const MinimumLegs& legs_;
  const Vec3& from_;
  const Vec3& to_;
  const double time_;  // the time at which the piece begins
  const Vec3 motion_ = to_ - from_;
  ContactFrame start_frame_;  // the contact frame at the start
  Vec3 direction_;            // unit, in the direction of travel at the start
  double sense_ = 1.0;        // 1: direction_ is that of the frame at the start; -1: the opposite
  double length_ = 0.0;
  Place end_;
};

bool MinimumLegs::make(const Vec3& from, const Vec3& to, double time, MinimumLeg& leg) const noexcept {
  constexpr int kMaxHalvings = 40;          // after these, there is no leg
  constexpr double kMinTime = 0x1p-44;      // share of the step
  constexpr double kUneven = 0x1p-20;       // share of the offset
  constexpr double kUnevenShare = 0x1p-24;  // share of the length of the piece
  const Vec3 device = on_path(from, to, time);
  const Vec3 motion = to - from;
  if (minimum_.is_on_axis(device)) {
    make_on_axis(from, to, time, leg);
    return true;
  }
  const bool is_straight = contacts_.is_flat();
  const Vec3 rate = is_straight ? Vec3::Zero() : minimum_.find_rate(centre_, device, motion);
  // The distance of the centre from the minimum for this device: if contacts meet at a small angle, a small tolerance makes it large.
  double centre_error = -1.0;
  const auto find_centre_error = [&] {
    Vec3 here = centre_;
    if (centre_error < 0.0) centre_error = minimum_.solve(device, here, work_) ? (here - centre_).norm() : 0.0;
    return centre_error;
  };
  // Whether the piece turns little and a cubic matches it in time: its speed changes by at most a factor of two, or its middle is near that
  // of the cubic. The piece begins at the centre, so its middle may be off by as much as the centre is off the minimum.
  const auto is_even = [&](const Vec3& c, double then) {
    if (minimum_.find_turn(c - centre_) > 2.0 * LocalMinimum::kTurn) return false;
    const double duration = then - time;
    const Vec3 rate_there = minimum_.find_rate(c, on_path(from, to, then), motion);
    const double start_speed = rate.norm();
    const double end_speed = rate_there.norm();
    if (std::max(start_speed, end_speed) <= 2.0 * std::min(start_speed, end_speed)) return true;
    Vec3 middle = 0.5 * (centre_ + c) + 0.125 * duration * (rate - rate_there);
    const Vec3 guess = middle;
    if (!minimum_.solve(on_path(from, to, time + 0.5 * duration), middle, work_)) return false;
    const double cubic_error = (middle - guess).norm();
    const double error_limit = kUneven * contacts_.offset() + kUnevenShare * (c - centre_).norm();
    return cubic_error <= error_limit || cubic_error <= error_limit + find_centre_error();
  };
  double span = 1.0 - time;
  if (!is_straight) span = std::min(span, LocalMinimum::kTurn / std::max(minimum_.find_turn(rate), 0x1p-100));
  Vec3 end;
  for (int i = 0;; ++i) {
    if (i == kMaxHalvings || !(span > kMinTime || span >= 1.0 - time)) return false;
    leg.time = span >= 1.0 - time ? 1.0 : time + span;
    end = centre_;
    if (minimum_.solve(on_path(from, to, leg.time), end, work_) && (is_straight || is_even(end, leg.time))) break;
    if (i == 0 && contacts_.active_count() == 2 && !is_straight && CurveSearch(*this, from, to, time).make(leg)) return true;
    span *= 0.5;
  }
  if (!end_at_release(from, to, time, leg, end)) return false;
  const double duration = leg.time - time;
  if (is_straight || !(duration > 0.0)) {
    leg.path = CentrePath::straight(centre_, end);
    return true;
  }
  const Vec3 rate_end = minimum_.find_rate(end, on_path(from, to, leg.time), motion);
  leg.path = CentrePath::curved(centre_, end, duration * rate, duration * rate_end);
  contacts_.guide(leg.path);
  return true;
}

// The device is on the axis of the contact: the centre keeps its angle about the axis, and slides along it if it is an edge.
void MinimumLegs::make_on_axis(const Vec3& from, const Vec3& to, double time, MinimumLeg& leg) const noexcept {
  leg.time = minimum_.time_off_axis(from, to, time);
  leg.released = -1;
  const OffsetContact& contact = contacts_[0];
  const Vec3 along = contact.part == Feature::edge ? Vec3(contact.axis * contact.axis.dot(to - from)) : Vec3(Vec3::Zero());
  leg.path = CentrePath::straight(centre_, centre_ + (leg.time - time) * along);
}

// The first multiplier that reaches zero ends the leg. `end`: the centre there.
bool MinimumLegs::end_at_release(const Vec3& from, const Vec3& to, double time, MinimumLeg& leg, Vec3& end) const noexcept {
  const auto multiplier = [&](const Vec3& c, const Vec3& at, int i) {
    ContactFrame frame;
    return contacts_.find_frame(c, frame) ? frame.dual[i].dot(c - at) : 0.0;
  };
  leg.released = -1;
  for (int i = 0; i < contacts_.active_count(); ++i) {
    const double at_end = multiplier(end, on_path(from, to, leg.time), i);
    if (!(at_end < -kAtMinimum)) continue;
    const auto multiplier_then = [&](double then) {
      Vec3 c = centre_ + (then - time) / (leg.time - time) * (end - centre_);
      return minimum_.solve(on_path(from, to, then), c, work_) ? multiplier(c, on_path(from, to, then), i)
                                                               : std::numeric_limits<double>::quiet_NaN();
    };
    const double at_start = std::max(0.0, multiplier(centre_, on_path(from, to, time), i));
    const double zero = find_release(time, at_start, leg.time, at_end, multiplier_then);
    leg.released = i;
    leg.time = zero;
    end = centre_;
    if (zero > time && !minimum_.solve(on_path(from, to, zero), end, work_)) return false;
  }
  return true;
}

}  // namespace hapton
