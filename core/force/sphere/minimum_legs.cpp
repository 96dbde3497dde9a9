#include "core/force/sphere/minimum_legs.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/math/find_zero.h"
#include "core/math/straight_motion.h"

namespace hapton {
namespace {

constexpr double kAtMinimum = LocalMinimum::kAtMinimum;

}  // namespace

bool MinimumLegs::make(const Vec3& from, const Vec3& to, double time, MinimumLeg& leg) const noexcept {
  constexpr int kMaxHalvings = 40;          // then there is no leg
  constexpr double kMinTime = 0x1p-44;      // of the step
  constexpr double kUneven = 0x1p-20;       // of the offset
  constexpr double kUnevenShare = 0x1p-24;  // of the length of the piece
  const Vec3 device = on_path(from, to, time);
  const Vec3 motion = to - from;
  if (minimum_.is_on_axis(device)) {
    make_on_axis(from, to, time, leg);
    return true;
  }
  const bool is_straight = !contacts_[0].is_curved() && (contacts_.active_count() == 1 || !contacts_[1].is_curved());
  const Vec3 rate = is_straight ? Vec3::Zero() : minimum_.find_rate(centre_, device, motion);
  // How far the centre is from the minimum for the device here: contacts at a small angle make a large distance of a small tolerance.
  double off = -1.0;
  const auto find_off = [&] {
    Vec3 here = centre_;
    if (off < 0.0) off = minimum_.solve(device, here, work_) ? (here - centre_).norm() : 0.0;
    return off;
  };
  // Whether the piece turns by little and a cubic keeps time with it: its speed changes by at most a factor of two, or its middle is
  // checked. The piece begins at the centre, and no middle is nearer to the path from there than the centre is to the minimum.
  const auto is_even = [&](const Vec3& c, double then) {
    if (minimum_.find_turn(c - centre_) > 2.0 * LocalMinimum::kTurn) return false;
    const double part = then - time;
    const Vec3 rate_there = minimum_.find_rate(c, on_path(from, to, then), motion);
    const double slow = rate.norm();
    const double fast = rate_there.norm();
    if (std::max(slow, fast) <= 2.0 * std::min(slow, fast)) return true;
    Vec3 middle = 0.5 * (centre_ + c) + 0.125 * part * (rate - rate_there);
    const Vec3 guess = middle;
    if (!minimum_.solve(on_path(from, to, time + 0.5 * part), middle, work_)) return false;
    const double uneven = (middle - guess).norm();
    const double most = kUneven * contacts_.offset() + kUnevenShare * (c - centre_).norm();
    return uneven <= most || uneven <= most + find_off();
  };
  double span = 1.0 - time;
  if (!is_straight) span = std::min(span, LocalMinimum::kTurn / std::max(minimum_.find_turn(rate), 0x1p-100));
  Vec3 end;
  for (int i = 0;; ++i) {
    if (i == kMaxHalvings || !(span > kMinTime || span >= 1.0 - time)) return false;
    leg.time = span >= 1.0 - time ? 1.0 : time + span;
    end = centre_;
    if (minimum_.solve(on_path(from, to, leg.time), end, work_) && (is_straight || is_even(end, leg.time))) break;
    if (i == 0 && contacts_.active_count() == 2 && !is_straight && make_on_curve(from, to, time, leg)) return true;
    span *= 0.5;
  }
  if (!end_at_release(from, to, time, leg, end)) return false;
  const double part = leg.time - time;
  if (is_straight || !(part > 0.0)) {
    leg.path = CentrePath::straight(centre_, end);
    return true;
  }
  const Vec3 rate_end = minimum_.find_rate(end, on_path(from, to, leg.time), motion);
  leg.path = CentrePath::curved(centre_, end, part * rate, part * rate_end);
  contacts_.guide(leg.path);
  return true;
}

// The device is on the axis of the contact: the centre keeps its angle, and slides along an edge.
void MinimumLegs::make_on_axis(const Vec3& from, const Vec3& to, double time, MinimumLeg& leg) const noexcept {
  leg.time = minimum_.time_off_axis(from, to, time);
  leg.released = -1;
  const OffsetContact& contact = contacts_[0];
  const Vec3 along = contact.part == Feature::edge ? Vec3(contact.axis * contact.axis.dot(to - from)) : Vec3(Vec3::Zero());
  leg.path = CentrePath::straight(centre_, centre_ + (leg.time - time) * along);
}

// The first multiplier that reaches zero ends the leg. `end`: the centre there.
bool MinimumLegs::end_at_release(const Vec3& from, const Vec3& to, double time, MinimumLeg& leg, Vec3& end) const noexcept {
  constexpr double kNearZero = 0x1p-50;  // rounding of a multiplier
  constexpr int kMaxGrowing = 8;         // quarterings of the leg, to find where a new multiplier has risen
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
    double begin = time;
    double at_start = std::max(0.0, multiplier(centre_, on_path(from, to, time), i));
    // The multiplier of a new contact begins at zero, and may rise before it falls to zero again.
    for (int k = 1; k <= kMaxGrowing && at_start <= kAtMinimum; ++k) {
      const double then = time + std::ldexp(leg.time - time, -2 * k);
      const double grown = multiplier_then(then);
      if (!(grown > kAtMinimum)) continue;
      begin = then;
      at_start = grown;
    }
    const double zero = find_zero(begin, at_start, leg.time, at_end, kNearZero, multiplier_then);
    leg.released = i;
    leg.time = zero;
    end = centre_;
    if (zero > time && !minimum_.solve(on_path(from, to, zero), end, work_)) return false;
  }
  return true;
}

}  // namespace hapton
