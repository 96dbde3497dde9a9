#include "core/force/sphere/drag_legs.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/math/find_zero.h"
#include "core/math/straight_motion.h"

namespace hapton {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kLeast = OffsetDrag::kLeastPull;
constexpr double kNearZero = 0x1p-51;          // rounding of a value that crosses zero
constexpr double kPositionRounding = 0x1p-52;  // of a coordinate, local units
// How far the middle of a piece may be off its cubic: a share of the offset, and of the length. Events are found on the cubic and placed on
// the exact path: an offset away from everything, so a centre that moves by a small part of the offset meets nothing.
constexpr double kUneven = 0x1p-16;
constexpr double kUnevenShare = 0x1p-20;
constexpr double kMostUneven = 0.125;
constexpr double kUnresolved =
    kLeast;                            // how far a centre that counts as on the cone may be off it: no shorter piece is nearer to its cubic
constexpr double kExact = 0x1p-42;     // local units: within this the cubic counts as the exact path
constexpr double kReleased = 0x1p-24;  // a pull at which the device counts as out
constexpr int kMostSearch = 16;        // rounds that look for an end; where a path can hardly be resolved, more find nothing nearer

double most_uneven(double offset, double length) { return kUneven * offset + std::min(kUnevenShare * length, kMostUneven * offset); }

}  // namespace

// Rounding of the components of a pull: that of the centre turns the normal of a curved part.
double DragLegs::rounding_of(const OffsetDrag::Pull& pull) const noexcept {
  const bool is_curved = contacts_[0].is_curved() || (contacts_.active_count() > 1 && contacts_[1].is_curved());
  return is_curved ? kPositionRounding * (pull.length + std::fabs(pull.depth)) / contacts_.offset() : 0.0;
}

bool DragLegs::make_slip(const OffsetDrag& drag, const OffsetDrag::Pull& pull, const Vec3& device, bool has_vanished,
                         SlipPath& slip) noexcept {
  constexpr int kMostRounds = 8;  // of Newton's method; then the slip goes as far as it may
  const double excess = pull.excess();
  const double stability = drag.find_stability(pull);
  slip.waits = false;
  slip.released = -1;
  slip.is_on_cone = !(pull.length > kLeast) ||
                    (!has_vanished && stability > LocalMinimum::kLeastStability && excess <= LocalMinimum::kAtMinimum * stability);
  if (slip.is_on_cone) return true;
  const Vec3 direction = pull.tangential / pull.length;
  const double turn = LocalMinimum::kTurn / std::max(minimum_.find_turn(direction), 0x1p-100);
  const double farthest = std::min(turn, 2.0 * pull.length);
  const double most = contacts_.active_count() == 1 ? std::min(turn, events_.distance_to_boundary(centre_, direction, farthest)) : turn;
  OffsetDrag::Pull there;
  OffsetDrag::Descent end;
  const auto go = [&](double length) {
    end.centre = centre_;
    return drag.descend(device, direction, length, end, work_) && drag.find_pull(end.centre, device, there);
  };
  const double rounding = std::max(kNearZero, rounding_of(pull));
  slip.stops = false;
  double length = most;
  if (!has_vanished && stability > LocalMinimum::kLeastStability && excess <= most * stability) {
    length = excess / stability;
    for (int i = 0; i < kMostRounds; ++i) {
      if (!go(length)) return false;
      const double left = there.excess();
      slip.stops = std::fabs(left) <= 2.0 * rounding || drag.is_flat();
      const double slope = drag.find_stability(there) * end.slope.norm();
      if (slip.stops || !(slope > LocalMinimum::kLeastStability)) break;
      length += left / slope;
      if (!(length > 0.0) || !(length <= most)) break;
    }
    if (!slip.stops) length = most;
  }
  const auto cut_at = [&](double at_start, double at_end, auto&& value) {
    length = find_zero(
        0.0, at_start, length, at_end, rounding, [&](double l) { return go(l) ? value() : -1.0; }, kMostSearch);
    slip.stops = false;
    return go(length);
  };
  if (!slip.stops) {
    if (!go(length)) return false;
    if (there.excess() < 0.0) {
      if (has_vanished) {
        slip.waits = true;
        return true;
      }
      if (!cut_at(excess, there.excess(), [&] { return there.excess(); })) return false;
      slip.stops = true;
    }
  }
  // A multiplier that turns negative ends the slip earlier.
  for (int i = 0; i < contacts_.active_count(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (there.multiplier[k] >= -LocalMinimum::kAtMinimum) continue;
    if (!cut_at(std::max(0.0, pull.multiplier[k]), there.multiplier[k], [&] { return there.multiplier[k]; })) return false;
    slip.released = i;
  }
  slip.direction = direction;
  for (int i = 0;; ++i) {
    slip.length = length;
    if (drag.is_flat() || !(length > 0.0)) {
      slip.path = CentrePath::straight(centre_, end.centre);
      return true;
    }
    const OffsetDrag::Descent last = end;
    slip.path = CentrePath::curved(centre_, last.centre, length * direction, length * last.slope);
    if (!go(0.5 * length)) return false;
    const Vec3 guess = 0.5 * (centre_ + last.centre) + 0.125 * length * (direction - last.slope);
    const double uneven = (end.centre - guess).norm();
    slip.is_exact = uneven <= kExact;
    if (i == kMostRounds || uneven <= most_uneven(contacts_.offset(), length)) break;
    length *= 0.5;
    slip.stops = false;
    slip.released = -1;
  }
  contacts_.guide(slip.path);
  return true;
}

DragOutcome DragLegs::make(const OffsetDrag& drag, const Vec3& from, const Vec3& to, double time, DragLeg& leg) noexcept {
  if (contacts_.active_count() == 3) return DragOutcome::stops;
  const bool is_round = contacts_.active_count() == 1 && contacts_[0].is_curved();
  return is_round ? make_flow_leg(drag, from, to, time, leg) : make_drag_leg(drag, from, to, time, leg);
}

DragOutcome DragLegs::make_drag_leg(const OffsetDrag& drag, const Vec3& from, const Vec3& to, double time, DragLeg& leg) noexcept {
  constexpr int kMostHalvings = 40;             // then the centre jumps
  constexpr int kTries = 3;                     // on a curved part; then the leg is integrated
  constexpr double kLeastTime = 0x1p-44;        // of the step
  constexpr double kLeastExcessRate = 0x1p-46;  // of the motion
  const Vec3 device = on_path(from, to, time);
  const Vec3 motion = to - from;
  OffsetDrag::Pull pull;
  if (!drag.find_pull(centre_, device, pull)) return DragOutcome::jumps;
  if (!(drag.find_excess_rate(pull, motion) > -kLeastExcessRate * motion.norm()) || motion.isZero(0.0)) return DragOutcome::stops;
  if (!(drag.find_stability(pull) > LocalMinimum::kLeastStability)) return DragOutcome::jumps;
  const bool is_flat = drag.is_flat();
  const Vec3 rate = drag.find_rate(pull, motion);
  leg.released = -1;
  leg.stops = false;
  leg.is_clear = false;
  leg.is_line = false;
  double span = 1.0 - time;
  double release = kInfinity;
  if (contacts_.active_count() == 1) {
    release = drag.time_of_release(device, to, pull);
    if (release < 1.0) span *= release;
  }
  const double release_span = span;
  if (!is_flat) span = std::min(span, LocalMinimum::kTurn / std::max(minimum_.find_turn(rate), 0x1p-100));
  if (const double speed = rate.norm(); contacts_.active_count() == 1 && speed > 0.0) {
    span = std::min(span, events_.distance_to_boundary(centre_, rate / speed, speed * span) / speed);
  }
  // Where the device comes out of the surface, the centre is at the device.
  const auto place_at = [&](double then, Vec3& c) {
    c = centre_;
    return drag.follow(device, on_path(from, to, then), c, work_);
  };
  Vec3 end;
  Vec3 middle;
  OffsetDrag::Pull there;
  bool is_straight = false;
  for (int i = 0;; ++i) {
    if (i == kTries && !is_flat) return make_flow_leg(drag, from, to, time, leg);
    if (i == kMostHalvings || (!(span > kLeastTime) && span < release_span)) return DragOutcome::jumps;
    const bool is_out = release < 1.0 && span >= release_span;
    leg.time = span >= 1.0 - time ? 1.0 : time + span;
    leg.released = is_out ? 0 : -1;
    const Vec3 half = on_path(from, to, time + 0.5 * (leg.time - time));
    const Vec3 then = on_path(from, to, leg.time);
    middle = centre_;
    if (drag.follow(device, half, middle, work_)) {
      end = middle;
      bool is_there = true;
      if (is_out) {
        end = then;
        is_there = drag.restore(end);
      } else {
        is_there = drag.follow(half, then, end, work_);
      }
      if (is_there && drag.find_pull(end, then, there) && (is_flat || minimum_.find_turn(end - centre_) <= 2.0 * LocalMinimum::kTurn)) {
        const Vec3 rate_there = drag.find_rate(there, motion);
        const Vec3 guess = 0.5 * (centre_ + end) + 0.125 * span * (rate - rate_there);
        is_straight = is_flat && contacts_.active_count() == 1 && (0.5 * (centre_ + end) - middle).norm() <= 0x1p-50 &&
                      span * (rate - rate_there).norm() <= 0x1p-48;
        const double uneven = (middle - guess).norm();
        leg.is_exact = contacts_.active_count() == 1 && uneven <= kExact;
        leg.is_line = is_flat && contacts_.active_count() == 2 && (middle - centre_).dot(end - middle) >= 0.0;
        if (leg.is_line) break;
        if (is_straight || uneven <= kUnresolved + most_uneven(contacts_.offset(), (end - centre_).norm())) break;
        leg.is_clear = is_flat && contacts_.active_count() == 1 &&
                       events_.is_clear_over_face(centre_, end, rate.normalized(), rate_there.normalized());
        if (leg.is_clear) break;
      }
    }
    span *= 0.5;
  }
  // The leg ends earlier where the drag stops or a contact is released.
  const auto cut_at = [&](double at_start, double at_end, auto&& value) {
    leg.time = find_zero(time, at_start, leg.time, at_end, kNearZero, [&](double then) {
      OffsetDrag::Pull at;
      Vec3 c;
      return place_at(then, c) && drag.find_pull(c, on_path(from, to, then), at) ? value(at) : -1.0;
    });
    end = centre_;
    return leg.time <= time || place_at(leg.time, end);
  };
  for (int i = 0; contacts_.active_count() == 2 && i < 2; ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (there.multiplier[k] >= -LocalMinimum::kAtMinimum) continue;
    leg.released = i;
    if (!cut_at(std::max(0.0, pull.multiplier[k]), there.multiplier[k], [&](const OffsetDrag::Pull& at) { return at.multiplier[k]; })) {
      return DragOutcome::jumps;
    }
    if (!drag.find_pull(end, on_path(from, to, leg.time), there)) return DragOutcome::jumps;
  }
  const bool may_stop = (!is_flat || contacts_.active_count() == 2) && !(contacts_.active_count() == 1 && leg.released >= 0);
  if (may_stop && drag.find_excess_rate(there, motion) < -kLeastExcessRate * motion.norm()) {
    leg.stops = true;
    leg.released = -1;
    if (!cut_at(std::max(0.0, drag.find_excess_rate(pull, motion)), drag.find_excess_rate(there, motion),
                [&](const OffsetDrag::Pull& at) { return drag.find_excess_rate(at, motion); })) {
      return DragOutcome::jumps;
    }
    if (leg.time <= time) return DragOutcome::stops;
  }
  const double part = leg.time - time;
  if (is_straight || leg.is_clear || leg.is_line || !(part > 0.0)) {
    leg.path = CentrePath::straight(centre_, end);
    return DragOutcome::moves;
  }
  if (!drag.find_pull(end, on_path(from, to, leg.time), there)) return DragOutcome::jumps;
  leg.path = CentrePath::curved(centre_, end, part * rate, part * drag.find_rate(there, motion));
  if (contacts_.active_count() == 2) contacts_.guide(leg.path);  // over a face the cubic stays in its plane
  return DragOutcome::moves;
}

// On curved parts the equilibrium on the cone may vanish: there the centre jumps.
DragOutcome DragLegs::make_flow_leg(const OffsetDrag& drag, const Vec3& from, const Vec3& to, double time, DragLeg& leg) noexcept {
  constexpr int kMostHalvings = 40;             // then the centre jumps
  constexpr int kFewHalvings = 3;               // then the shortest leg is tried first
  constexpr int kMostRounds = 8;                // to get from the end of the leg to the target; a bound on the work
  constexpr double kMostShrunk = 0x1p-10;       // of the length, at once
  constexpr double kLeastExcessRate = 0x1p-46;  // of the motion
  const Vec3 motion = to - from;
  const double speed = motion.norm();
  const Vec3 device = on_path(from, to, time);
  OffsetDrag::Pull pull;
  if (!drag.find_pull(centre_, device, pull)) return DragOutcome::jumps;
  const double excess_rate = drag.find_excess_rate(pull, motion);
  if (!(excess_rate > -kLeastExcessRate * speed) || !(speed > 0.0)) return DragOutcome::stops;
  const double stability = drag.find_stability(pull);
  if (!(stability > LocalMinimum::kLeastStability)) return DragOutcome::jumps;
  const double release = contacts_.active_count() == 1 ? drag.time_of_release(device, to, pull) : kInfinity;
  bool comes_out = release < 1.0;
  double target = comes_out ? time + release * (1.0 - time) : 1.0;
  leg.released = -1;
  leg.stops = false;
  leg.jumps = false;
  leg.is_exact = false;
  // Almost nothing is left of the pull, and all of it vanishes on this leg.
  constexpr double kSmallPull = 0x1p-9;  // of the offset
  constexpr double kShort = 0x1p-5;      // of the offset
  if (comes_out && pull.length + pull.depth <= kSmallPull * contacts_.offset() && (target - time) * speed <= kShort * contacts_.offset()) {
    return make_last_leg(on_path(from, to, target), target, pull.normal, leg);
  }
  const Vec3 slope = drag.find_slope(pull, motion);
  const double turn = LocalMinimum::kTurn / std::max(minimum_.find_turn(slope), 0x1p-100);
  const double most = contacts_.active_count() == 1 && excess_rate > 0.0
                          ? std::min(turn, events_.distance_to_boundary(centre_, slope / excess_rate, turn * excess_rate) / excess_rate)
                          : turn;
  // No longer than one integration leads, as far as the last one tells. Along the curve of two contacts nothing is integrated.
  constexpr int kStepsOfLeg = OffsetDrag::kMostSteps - 4;
  const double within_reach = contacts_.active_count() == 1 && step_ > 0.0 ? std::min(most, kStepsOfLeg * step_) : most;
  double length = std::min(within_reach, (target - time) / stability);
  OffsetDrag::Flow end{centre_, time};
  OffsetDrag::Pull there;
  OffsetDrag::Flow middle;
  double half = 0.0;       // the length to `middle`
  double travelled = 0.0;  // the length to `end`
  double shrink = 0.5;     // the next length, as a share of this one
  double off = 0.0;        // how far the centre is from the cone: contacts at a small angle make a large distance of a small tolerance
  // From the start or from the last position, whichever is nearer.
  const auto go = [&](double l) {
    if (std::fabs(l - travelled) >= l || contacts_.active_count() == 2) {
      end = {centre_, time, step_};
      travelled = 0.0;
    }
    const double advance = l - travelled;
    travelled = l;
    if (advance == 0.0 || (drag.flow(from, to, advance, end, work_) && drag.find_pull(end.centre, from + end.time * motion, there)))
      return true;
    travelled += end.followed - advance;
    step_ = end.step;
    shrink = std::clamp(0.75 * travelled / length, kMostShrunk, 0.5);
    end = {centre_, time};
    travelled = 0.0;
    return false;
  };
  const auto seek = [&](double at_start, double at_end, double rounding, auto&& value) {
    length = find_zero(
        0.0, at_start, length, at_end, std::max(kNearZero, rounding), [&](double l) { return go(l) ? value() : -1.0; }, kMostSearch);
    return go(length);
  };
  const double of_pull = rounding_of(pull);
  const auto left = [&] { return target - end.time; };
  const auto stability_there = [&] { return drag.find_stability(there); };
  bool is_at_target = false;
  for (int i = 0;; ++i, length *= shrink) {
    if (i == kMostHalvings) return DragOutcome::jumps;
    shrink = 0.5;
    is_at_target = false;
    leg.jumps = false;
    end = {centre_, time, step_};
    travelled = 0.0;
    if (i == kFewHalvings) {
      if (!go(std::ldexp(length, kFewHalvings - kMostHalvings))) return DragOutcome::jumps;  // however short
      off = (end.centre - centre_).norm();
    }
    if (!go(0.5 * length)) continue;
    middle = end;
    half = 0.5 * length;
    if (!go(length) || minimum_.find_turn(end.centre - centre_) > 2.0 * LocalMinimum::kTurn) continue;
    step_ = end.step;
    const Vec3 guess = 0.5 * (centre_ + end.centre) + 0.125 * length * (slope - end.slope);
    const double uneven = (middle.centre - guess).norm();
    const double most_off = kUnresolved + off + most_uneven(contacts_.offset(), (end.centre - centre_).norm());
    if (uneven > most_off) {  // of fourth order in the length
      shrink = std::clamp(0.9 * std::sqrt(std::sqrt(most_off / uneven)), kMostShrunk, 0.5);
      continue;
    }
    // A little farther, to the end of the leg.
    for (int round = 0; round < kMostRounds && i == 0 && length < most && left() > 0.0; ++round) {
      const double on = left() / std::max(stability_there(), 0x1p-10);
      is_at_target = on * speed <= 0x1p-50;
      if (is_at_target || !(length + on <= 1.125 * std::min(most, 2.0 * length))) break;
      if (!go(length + on)) break;
      length += on;
    }
    if (!go(length)) continue;
    if (stability_there() < 0.0) {
      if (!seek(stability, stability_there(), of_pull / contacts_.offset(), stability_there)) continue;
      is_at_target = false;
      leg.jumps = true;
    }
    if (left() < 0.0) {
      if (!seek(target - time, left(), 0.0, left)) continue;
      is_at_target = true;
      leg.jumps = false;
    }
    if (is_at_target && comes_out && there.length > kReleased) {  // the device comes out at another point
      comes_out = false;
      target = 1.0;
      length = std::min(most, (target - time) / stability);
      i = -1;
      shrink = 1.0;
      continue;
    }
    break;
  }
  for (int i = 0; contacts_.active_count() == 2 && i < 2; ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (there.multiplier[k] >= -LocalMinimum::kAtMinimum) continue;
    if (!seek(std::max(0.0, pull.multiplier[k]), there.multiplier[k], of_pull, [&] { return there.multiplier[k]; }))
      return DragOutcome::jumps;
    leg.released = i;
    leg.jumps = false;
    is_at_target = false;
  }
  const double excess_rate_there = drag.find_excess_rate(there, motion);
  if (excess_rate_there < -kLeastExcessRate * speed && !(is_at_target && comes_out)) {
    const double of_direction = speed * kPositionRounding / std::max(there.length, kLeast);
    if (!seek(std::max(0.0, excess_rate), excess_rate_there, of_direction, [&] { return drag.find_excess_rate(there, motion); }) ||
        !(length > 0.0))
      return DragOutcome::stops;
    is_at_target = false;
    leg.jumps = false;
    leg.stops = true;
    leg.released = -1;
  }
  leg.time = is_at_target ? target : std::min(end.time, target);
  if (is_at_target && comes_out) {
    leg.released = 0;
    end.centre = on_path(from, to, target);
    if (!drag.restore(end.centre)) return DragOutcome::jumps;
  }
  leg.flow = length;
  leg.path = CentrePath::curved(centre_, end.centre, length * slope, length * end.slope);
  contacts_.guide(leg.path);
  leg.pace = {length * stability, length * stability_there()};
  const double share = length > 0.0 ? half / length : 0.0;
  leg.is_exact = contacts_.active_count() == 1 && share > 0.25 && share < 0.75 && (leg.path.at(share) - middle.centre).norm() <= kExact &&
                 std::fabs(leg.time_at(time, share) - middle.time) * speed <= kExact;
  return DragOutcome::moves;
}

// To the point where the device comes out.
DragOutcome DragLegs::make_last_leg(const Vec3& device, double time, const Vec3& normal, DragLeg& leg) const noexcept {
  Vec3 end = device;
  if (!contacts_.restore(end, work_)) return DragOutcome::jumps;
  const Vec3 chord = end - centre_;
  const Vec3 normal_there = contacts_[0].proximity(end).normal;
  leg.time = time;
  leg.released = 0;
  leg.is_exact = true;
  leg.path = CentrePath::curved(centre_, end, chord - normal.dot(chord) * normal, chord - normal_there.dot(chord) * normal_there);
  contacts_.guide(leg.path);
  return DragOutcome::moves;
}

}  // namespace hapton
