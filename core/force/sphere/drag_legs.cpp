// The slips, and the drags computed by OffsetDrag::follow(). drag_flow_legs.cpp has the drags computed by OffsetDrag::flow().
#include "core/force/sphere/drag_legs.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/math/find_zero.h"
#include "core/math/straight_motion.h"

namespace hapton {

double DragLegs::max_cubic_error(double length) const noexcept {
  constexpr double kUneven = 0x1p-16;
  constexpr double kUnevenShare = 0x1p-20;
  constexpr double kMaxUneven = 0.125;
  const double offset = contacts_.offset();
  return kUneven * offset + std::min(kUnevenShare * length, kMaxUneven * offset);
}

double DragLegs::rounding_of(const OffsetDrag::Pull& pull) const noexcept {
  return contacts_.is_flat() ? 0.0 : kPositionRounding * (pull.length + std::fabs(pull.depth)) / contacts_.offset();
}

class DragLegs::SlipSearch {
 public:
  SlipSearch(DragLegs& legs, const OffsetDrag& drag, const OffsetDrag::Pull& pull, const Vec3& device, bool has_vanished) noexcept
      : legs_(legs), drag_(drag), pull_(pull), device_(device), has_vanished_(has_vanished), stability_(drag.find_stability(pull)) {}

  bool make(SlipPath& slip) noexcept {
    slip.is_on_cone = !(pull_.length > OffsetDrag::kMinPull) || reaches_cone_within(LocalMinimum::kAtMinimum);
    if (slip.is_on_cone) return true;
    slip.direction = pull_.tangential / pull_.length;
    rounding_ = std::max(kNearZero, legs_.rounding_of(pull_));
    if (!find_length(slip)) return false;
    return slip.waits || (end_at_release(slip) && make_path(slip));
  }

 private:
  bool reaches_cone_within(double length) const noexcept {
    return !has_vanished_ && stability_ > LocalMinimum::kMinStability && pull_.excess() <= length * stability_;
  }

  double find_most(const Vec3& direction) noexcept {
    const double turn = LocalMinimum::kTurn / std::max(legs_.minimum_.find_turn(direction), 0x1p-100);
    const double farthest = std::min(turn, 2.0 * pull_.length);
    if (legs_.contacts_.active_count() != 1) return turn;
    return std::min(turn, legs_.events_.distance_to_boundary(legs_.centre_, direction, farthest));
  }

  // Moves end_ to this length along the slip, and finds the pull there. False: one of the two cannot be computed.
  bool go(const Vec3& direction, double length) noexcept {
    end_.centre = legs_.centre_;
    return drag_.descend(device_, direction, length, end_, legs_.work_) && drag_.find_pull(end_.centre, device_, end_pull_);
  }

  // Shortens the slip so that it ends where `value()` reaches zero. False: the slip cannot be computed there.
  template <class Value>
  bool cut_at(SlipPath& slip, double at_start, double at_end, Value&& value) noexcept {
    length_ = find_zero(
        0.0, at_start, length_, at_end, rounding_, [&](double l) { return go(slip.direction, l) ? value() : -1.0; }, kMaxSearch);
    slip.stops = false;
    return go(slip.direction, length_);
  }

  // Sets the length of the slip: the largest length of a piece, or to the cone if that is nearer. False: it cannot be computed.
  bool find_length(SlipPath& slip) noexcept {
    const double most = find_most(slip.direction);
    length_ = most;
    if (reaches_cone_within(most) && !approach_cone(slip, most)) return false;
    if (slip.stops) return true;
    if (!go(slip.direction, length_)) return false;
    if (!(end_pull_.excess() < 0.0)) return true;
    if (has_vanished_) {
      slip.waits = true;
      return true;
    }
    if (!cut_at(slip, pull_.excess(), end_pull_.excess(), [&] { return end_pull_.excess(); })) return false;
    slip.stops = true;
    return true;
  }

  // Finds the length at which the pull is on the cone, by Newton's method. If it is not found, the length is `most`. False: go() failed.
  bool approach_cone(SlipPath& slip, double most) noexcept {
    length_ = pull_.excess() / stability_;
    for (int i = 0; i < kMaxRounds; ++i) {
      if (!go(slip.direction, length_)) return false;
      const double excess_left = end_pull_.excess();
      slip.stops = std::fabs(excess_left) <= 2.0 * rounding_ || drag_.is_flat();
      const double slope = drag_.find_stability(end_pull_) * end_.slope.norm();
      if (slip.stops || !(slope > LocalMinimum::kMinStability)) break;
      length_ += excess_left / slope;
      if (!(length_ > 0.0) || !(length_ <= most)) break;
    }
    if (!slip.stops) length_ = most;
    return true;
  }

  // A multiplier that turns negative ends the slip earlier.
  bool end_at_release(SlipPath& slip) noexcept {
    for (int i = 0; i < legs_.contacts_.active_count(); ++i) {
      if (end_pull_.multiplier[i] >= -LocalMinimum::kAtMinimum) continue;
      if (!cut_at(slip, std::max(0.0, pull_.multiplier[i]), end_pull_.multiplier[i], [&] { return end_pull_.multiplier[i]; })) return false;
      slip.released = i;
    }
    return true;
  }

  // Halves the slip until it is nearly a cubic. If the device is straight below an edge, the centre moves far along the edge, then crosses
  // to its other side within one offset: one cubic for all of this would lead through the faces. False: no such length is found.
  bool make_path(SlipPath& slip) noexcept {
    const Vec3& centre = legs_.centre_;
    const Vec3& direction = slip.direction;
    for (int i = 0; i <= kMaxHalvings; ++i) {
      slip.length = length_;
      if (drag_.is_flat() || !(length_ > 0.0)) {
        slip.path = CentrePath::straight(centre, end_.centre);
        return true;
      }
      const OffsetDrag::Descent last = end_;
      slip.path = CentrePath::curved(centre, last.centre, length_ * direction, length_ * last.slope);
      if (!go(direction, 0.5 * length_)) return false;
      const Vec3 guess = 0.5 * (centre + last.centre) + 0.125 * length_ * (direction - last.slope);
      const double cubic_error = (end_.centre - guess).norm();
      slip.is_exact = cubic_error <= kExact;
      if (cubic_error <= legs_.max_cubic_error(length_)) {
        legs_.contacts_.guide(slip.path);
        return true;
      }
      length_ *= 0.5;
      slip.stops = false;
      slip.released = -1;
    }
    return false;
  }

  static constexpr int kMaxRounds = 8;     // rounds of Newton's method
  static constexpr int kMaxHalvings = 40;  // enough to get from the size of the scene to a thousandth of a contact offset

  DragLegs& legs_;
  const OffsetDrag& drag_;
  const OffsetDrag::Pull& pull_;  // at the start of the slip
  const Vec3& device_;
  const bool has_vanished_;
  const double stability_;  // at the start of the slip
  double rounding_ = 0.0;   // rounding error of a pull
  double length_ = 0.0;     // length of the slip
  OffsetDrag::Descent end_;
  OffsetDrag::Pull end_pull_;  // the pull at end_
};

bool DragLegs::make_slip(const OffsetDrag& drag, const OffsetDrag::Pull& pull, const Vec3& device, bool has_vanished,
                         SlipPath& slip) noexcept {
  return SlipSearch(*this, drag, pull, device, has_vanished).make(slip);
}

DragOutcome DragLegs::make(const OffsetDrag& drag, const Vec3& from, const Vec3& to, double time, DragLeg& leg) noexcept {
  if (contacts_.active_count() == 3) return DragOutcome::stops;
  const bool is_round = contacts_.active_count() == 1 && contacts_[0].is_curved();
  return is_round ? make_flow_leg(drag, from, to, time, leg) : make_followed_leg(drag, from, to, time, leg);
}

class DragLegs::FollowSearch {
 public:
  FollowSearch(DragLegs& legs, const OffsetDrag& drag, const Vec3& from, const Vec3& to, double time) noexcept
      : legs_(legs), drag_(drag), from_(from), to_(to), time_(time), motion_(to - from), device_(on_path(from, to, time)) {}

  DragOutcome make(DragLeg& leg) noexcept {
    if (!drag_.find_pull(legs_.centre_, device_, pull_)) return DragOutcome::jumps;
    if (!(drag_.find_excess_rate(pull_, motion_) > least_excess_rate()) || motion_.isZero(0.0)) return DragOutcome::stops;
    if (!(drag_.find_stability(pull_) > LocalMinimum::kMinStability)) return DragOutcome::jumps;
    rate_ = drag_.find_rate(pull_, motion_);
    find_span();
    if (const auto other = find_end(leg)) return *other;
    if (!end_at_release(leg)) return DragOutcome::jumps;
    if (may_stop(leg) && drag_.find_excess_rate(end_pull_, motion_) < least_excess_rate()) {
      if (!end_where_it_stops(leg)) return DragOutcome::jumps;
      if (leg.time <= time_) return DragOutcome::stops;
    }
    return make_path(leg);
  }

 private:
  bool has_one_contact() const noexcept { return legs_.contacts_.active_count() == 1; }
  double least_excess_rate() const noexcept { return -kMinExcessRate * motion_.norm(); }
  Vec3 device_at(double time) const noexcept { return on_path(from_, to_, time); }

  // The longest time that the leg may take.
  void find_span() noexcept {
    span_ = 1.0 - time_;
    if (has_one_contact()) {
      release_share_ = drag_.time_of_release(device_, to_, pull_);
      if (release_share_ < 1.0) span_ *= release_share_;
    }
    release_span_ = span_;
    if (!is_flat_) span_ = std::min(span_, LocalMinimum::kTurn / std::max(legs_.minimum_.find_turn(rate_), 0x1p-100));
    if (const double speed = rate_.norm(); has_one_contact() && speed > 0.0) {
      span_ = std::min(span_, legs_.events_.distance_to_boundary(legs_.centre_, rate_ / speed, speed * span_) / speed);
    }
  }

  // Halves the span until the path is simple enough. Returns the outcome if the search ends here; none: the search continues.
  std::optional<DragOutcome> find_end(DragLeg& leg) noexcept {
    constexpr int kMaxHalvings = 40;      // after these, the centre jumps
    constexpr int kTries = 3;             // on a curved part; after these, the leg is integrated
    constexpr double kMinTime = 0x1p-44;  // share of the step
    for (int i = 0;; ++i) {
      if (i == kTries && !is_flat_) return legs_.make_flow_leg(drag_, from_, to_, time_, leg);
      if (i == kMaxHalvings || (!(span_ > kMinTime) && span_ < release_span_)) return DragOutcome::jumps;
      if (follow_span(leg) && is_even(leg)) return std::nullopt;
      span_ *= 0.5;
    }
  }

  // Follows the device to the end of the span. False: the centre cannot follow, or its path turns too far.
  bool follow_span(DragLeg& leg) noexcept {
    const bool is_out = release_share_ < 1.0 && span_ >= release_span_;
    leg.time = span_ >= 1.0 - time_ ? 1.0 : time_ + span_;
    leg.released = is_out ? 0 : -1;
    const Vec3 device_middle = device_at(time_ + 0.5 * (leg.time - time_));
    const Vec3 device_end = device_at(leg.time);
    middle_ = legs_.centre_;
    if (!drag_.follow(device_, device_middle, middle_, legs_.work_)) return false;
    end_ = is_out ? device_end : middle_;  // where the device comes out of the surface, the centre is at the device
    if (!(is_out ? drag_.restore(end_) : drag_.follow(device_middle, device_end, end_, legs_.work_))) return false;
    if (!drag_.find_pull(end_, device_end, end_pull_)) return false;
    return is_flat_ || legs_.minimum_.find_turn(end_ - legs_.centre_) <= 2.0 * LocalMinimum::kTurn;
  }

  // Whether the path is a line, is nearly a cubic, or meets nothing.
  bool is_even(DragLeg& leg) noexcept {
    const Vec3& centre = legs_.centre_;
    const Vec3 rate_there = drag_.find_rate(end_pull_, motion_);
    const Vec3 guess = 0.5 * (centre + end_) + 0.125 * span_ * (rate_ - rate_there);
    is_straight_ = is_flat_ && has_one_contact() && (0.5 * (centre + end_) - middle_).norm() <= 0x1p-50 &&
                   span_ * (rate_ - rate_there).norm() <= 0x1p-48;
    const double cubic_error = (middle_ - guess).norm();
    leg.is_exact = has_one_contact() && cubic_error <= kExact;
    leg.is_line = is_flat_ && legs_.contacts_.active_count() == 2 && (middle_ - centre).dot(end_ - middle_) >= 0.0;
    if (leg.is_line) return true;
    if (is_straight_ || cubic_error <= kUnresolved + legs_.max_cubic_error((end_ - centre).norm())) return true;
    leg.is_clear =
        is_flat_ && has_one_contact() && legs_.events_.is_clear_over_face(centre, end_, rate_.normalized(), rate_there.normalized());
    return leg.is_clear;
  }

  // Ends the leg where `value(pull)` reaches zero. False: the centre cannot follow the device to that time.
  template <class Value>
  bool cut_at(DragLeg& leg, double at_start, double at_end, Value&& value) noexcept {
    const auto follow_to = [&](double then, Vec3& c) {
      c = legs_.centre_;
      return drag_.follow(device_, device_at(then), c, legs_.work_);
    };
    leg.time = find_zero(time_, at_start, leg.time, at_end, kNearZero, [&](double then) {
      OffsetDrag::Pull at;
      Vec3 c;
      return follow_to(then, c) && drag_.find_pull(c, device_at(then), at) ? value(at) : -1.0;
    });
    end_ = legs_.centre_;
    return leg.time <= time_ || follow_to(leg.time, end_);
  }

  // With two contacts: if the multiplier of one turns negative, ends the leg earlier, where it is zero.
  bool end_at_release(DragLeg& leg) noexcept {
    for (int i = 0; legs_.contacts_.active_count() == 2 && i < 2; ++i) {
      if (end_pull_.multiplier[i] >= -LocalMinimum::kAtMinimum) continue;
      leg.released = i;
      if (!cut_at(leg, std::max(0.0, pull_.multiplier[i]), end_pull_.multiplier[i],
                  [&](const OffsetDrag::Pull& at) { return at.multiplier[i]; })) {
        return false;
      }
      if (!drag_.find_pull(end_, device_at(leg.time), end_pull_)) return false;
    }
    return true;
  }

  bool may_stop(const DragLeg& leg) const noexcept {
    return (!is_flat_ || legs_.contacts_.active_count() == 2) && !(has_one_contact() && leg.released >= 0);
  }

  bool end_where_it_stops(DragLeg& leg) noexcept {
    leg.stops = true;
    leg.released = -1;
    const auto excess_rate = [&](const OffsetDrag::Pull& at) { return drag_.find_excess_rate(at, motion_); };
    return cut_at(leg, std::max(0.0, excess_rate(pull_)), excess_rate(end_pull_), excess_rate);
  }

  DragOutcome make_path(DragLeg& leg) noexcept {
    const double duration = leg.time - time_;
    if (is_straight_ || leg.is_clear || leg.is_line || !(duration > 0.0)) {
      leg.path = CentrePath::straight(legs_.centre_, end_);
      return DragOutcome::moves;
    }
    if (!drag_.find_pull(end_, device_at(leg.time), end_pull_)) return DragOutcome::jumps;
    leg.path = CentrePath::curved(legs_.centre_, end_, duration * rate_, duration * drag_.find_rate(end_pull_, motion_));
    if (legs_.contacts_.active_count() == 2) legs_.contacts_.guide(leg.path);  // on a face it stays in the plane without a guide
    return DragOutcome::moves;
  }

  DragLegs& legs_;
  const OffsetDrag& drag_;
  const Vec3& from_;
  const Vec3& to_;
  const double time_;  // start of the leg; device_, pull_ and rate_ are those at this time
  const Vec3 motion_;
  const Vec3 device_;
  const bool is_flat_ = drag_.is_flat();
  OffsetDrag::Pull pull_;
  Vec3 rate_;
  double release_share_ = std::numeric_limits<double>::infinity();  // when the device leaves the surface, as a share of the time left
  double release_span_ = 0.0;
  double span_ = 0.0;  // duration of the leg
  bool is_straight_ = false;
  Vec3 middle_;
  Vec3 end_;
  OffsetDrag::Pull end_pull_;  // the pull at end_
};

// Flattened, so that the search stays in registers: nearly every step under friction comes here.
[[gnu::flatten]] DragOutcome DragLegs::make_followed_leg(const OffsetDrag& drag, const Vec3& from, const Vec3& to, double time,
                                                         DragLeg& leg) noexcept {
  return FollowSearch(*this, drag, from, to, time).make(leg);
}

}  // namespace hapton
