// Drags that OffsetDrag integrates, around an edge or a vertex and along sharp curves, in the parameter of OffsetDrag::Flow.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/force/sphere/drag_legs.h"
#include "core/math/find_zero.h"
#include "core/math/straight_motion.h"

namespace hapton {

class DragLegs::FlowSearch {
 public:
  FlowSearch(DragLegs& legs, const OffsetDrag& drag, const Vec3& from, const Vec3& to, double time) noexcept
      : legs_(legs), drag_(drag), from_(from), to_(to), time_(time), motion_(to - from), speed_(motion_.norm()) {}

  DragOutcome make(DragLeg& leg) noexcept {
    if (const auto other = begin(leg)) return *other;
    if (!find_length(leg)) return DragOutcome::jumps;
    if (!end_at_release(leg)) return DragOutcome::jumps;
    if (!end_where_it_stops(leg)) return DragOutcome::stops;
    return make_path(leg);
  }

 private:
  bool has_one_contact() const noexcept { return legs_.contacts_.active_count() == 1; }
  double time_left() const noexcept { return target_time_ - end_.time; }
  double end_stability() const noexcept { return drag_.find_stability(end_pull_); }

  // Begins the leg. Returns the outcome if the centre stops or jumps at once, or if the leg is the last one.
  std::optional<DragOutcome> begin(DragLeg& leg) noexcept {
    constexpr double kSmallPull = 0x1p-9;  // share of the offset
    constexpr double kShort = 0x1p-5;      // share of the offset
    const Vec3 device = on_path(from_, to_, time_);
    if (!drag_.find_pull(legs_.centre_, device, pull_)) return DragOutcome::jumps;
    excess_rate_ = drag_.find_excess_rate(pull_, motion_);
    if (!(excess_rate_ > -kMinExcessRate * speed_) || !(speed_ > 0.0)) return DragOutcome::stops;
    stability_ = drag_.find_stability(pull_);
    if (!(stability_ > LocalMinimum::kMinStability)) return DragOutcome::jumps;
    const double release = has_one_contact() ? drag_.time_of_release(device, to_, pull_) : std::numeric_limits<double>::infinity();
    device_comes_out_ = release < 1.0;
    target_time_ = device_comes_out_ ? time_ + release * (1.0 - time_) : 1.0;
    leg.released = -1;
    // Almost nothing is left of the pull, and all of it vanishes on this leg.
    const double offset = legs_.contacts_.offset();
    if (device_comes_out_ && pull_.length + pull_.depth <= kSmallPull * offset && (target_time_ - time_) * speed_ <= kShort * offset) {
      return legs_.make_last_leg(on_path(from_, to_, target_time_), target_time_, pull_.normal, leg);
    }
    slope_ = drag_.find_slope(pull_, motion_);
    return std::nullopt;
  }

  // The longest leg: as far as it may turn, or to the boundary of the part.
  double find_most() noexcept {
    const double turn = LocalMinimum::kTurn / std::max(legs_.minimum_.find_turn(slope_), 0x1p-100);
    if (!has_one_contact() || !(excess_rate_ > 0.0)) return turn;
    const Vec3 direction = slope_ / excess_rate_;
    return std::min(turn, legs_.events_.distance_to_boundary(legs_.centre_, direction, turn * excess_rate_) / excess_rate_);
  }

  void go_back() noexcept {
    end_ = {legs_.centre_, time_, legs_.step_};
    travelled_ = 0.0;
  }

  // Moves the end of the leg to that length, from the start or from the last end, whichever is nearer. False: the end is at the start
  // again, and `next_share_` says how far it came.
  bool go(double length) noexcept {
    constexpr double kFollowedShare = 0.75;  // the next length, as a share of what could be followed
    if (std::fabs(length - travelled_) >= length || legs_.contacts_.active_count() == 2) go_back();
    const double advance = length - travelled_;
    travelled_ = length;
    if (advance == 0.0 ||
        (drag_.flow(from_, to_, advance, end_, legs_.work_) && drag_.find_pull(end_.centre, from_ + end_.time * motion_, end_pull_))) {
      return true;
    }
    travelled_ += end_.followed - advance;
    legs_.step_ = end_.step;
    next_share_ = std::clamp(kFollowedShare * travelled_ / length_, kMinNextShare, 0.5);
    end_ = {legs_.centre_, time_};
    travelled_ = 0.0;
    return false;
  }

  // Moves the end of the leg to where `value()` reaches zero.
  template <class Value>
  bool seek(double at_start, double at_end, double rounding, Value&& value) noexcept {
    length_ = find_zero(
        0.0, at_start, length_, at_end, std::max(kNearZero, rounding), [&](double l) { return go(l) ? value() : -1.0; }, kMaxSearch);
    return go(length_);
  }

  // Shortens the leg until it is nearly a cubic, and ends it where the equilibrium vanishes or at the target.
  bool find_length(DragLeg& leg) noexcept {
    constexpr int kMaxHalvings = 40;                        // after these the centre jumps
    constexpr int kFewHalvings = 3;                         // after these the shortest leg is tried first
    constexpr int kStepsOfLeg = OffsetDrag::kMaxSteps - 4;  // no longer than one integration reaches, judged by its last step
    const double most = find_most();
    // Along the curve of two contacts nothing is integrated.
    const double within_reach = has_one_contact() && legs_.step_ > 0.0 ? std::min(most, kStepsOfLeg * legs_.step_) : most;
    length_ = std::min(within_reach, (target_time_ - time_) / stability_);
    for (int i = 0;; ++i, length_ *= next_share_) {
      if (i == kMaxHalvings) return false;
      next_share_ = 0.5;
      is_at_target_ = false;
      leg.jumps = false;
      go_back();
      if (i == kFewHalvings) {
        if (!go(std::ldexp(length_, kFewHalvings - kMaxHalvings))) return false;  // not even the shortest leg
        distance_off_cone_ = (end_.centre - legs_.centre_).norm();
      }
      if (!flow_evenly()) continue;
      if (i == 0) lengthen(most);
      if (!go(length_) || !end_where_it_vanishes(leg) || !end_at_target(leg)) continue;
      if (!is_at_target_ || !device_comes_out_ || !(end_pull_.length > kReleasedPull)) return true;
      device_comes_out_ = false;  // the device comes out at another point
      target_time_ = 1.0;
      length_ = std::min(most, (target_time_ - time_) / stability_);
      i = -1;
      next_share_ = 1.0;
    }
  }

  // Follows the leg to its end. False: it cannot be followed, turns too far, or is not nearly a cubic; `next_share_` is the share to try
  // next.
  bool flow_evenly() noexcept {
    const Vec3& centre = legs_.centre_;
    if (!go(0.5 * length_)) return false;
    middle_ = end_;
    middle_length_ = 0.5 * length_;
    if (!go(length_) || legs_.minimum_.find_turn(end_.centre - centre) > 2.0 * LocalMinimum::kTurn) return false;
    legs_.step_ = end_.step;
    const Vec3 guess = 0.5 * (centre + end_.centre) + 0.125 * length_ * (slope_ - end_.slope);
    const double cubic_error = (middle_.centre - guess).norm();
    const double error_limit = kUnresolved + distance_off_cone_ + legs_.max_cubic_error((end_.centre - centre).norm());
    if (!(cubic_error > error_limit)) return true;
    next_share_ = std::clamp(0.9 * std::sqrt(std::sqrt(error_limit / cubic_error)), kMinNextShare,
                             0.5);  // the error is of fourth order in the length
    return false;
  }

  // Makes the leg a little longer if it then reaches the target.
  void lengthen(double most) noexcept {
    constexpr int kMaxRounds = 8;  // a bound on the work
    for (int round = 0; round < kMaxRounds && length_ < most && time_left() > 0.0; ++round) {
      const double extension = time_left() / std::max(end_stability(), 0x1p-10);
      is_at_target_ = extension * speed_ <= 0x1p-50;
      if (is_at_target_ || !(length_ + extension <= 1.125 * std::min(most, 2.0 * length_))) break;
      if (!go(length_ + extension)) break;
      length_ += extension;
    }
  }

  bool end_where_it_vanishes(DragLeg& leg) noexcept {
    if (!(end_stability() < 0.0)) return true;
    const double rounding = legs_.rounding_of(pull_) / legs_.contacts_.offset();
    if (!seek(stability_, end_stability(), rounding, [&] { return end_stability(); })) return false;
    is_at_target_ = false;
    leg.jumps = true;
    return true;
  }

  bool end_at_target(DragLeg& leg) noexcept {
    if (!(time_left() < 0.0)) return true;
    if (!seek(target_time_ - time_, time_left(), 0.0, [&] { return time_left(); })) return false;
    is_at_target_ = true;
    leg.jumps = false;
    return true;
  }

  // One of two contacts whose multiplier turns negative ends the leg earlier.
  bool end_at_release(DragLeg& leg) noexcept {
    for (int i = 0; legs_.contacts_.active_count() == 2 && i < 2; ++i) {
      if (end_pull_.multiplier[i] >= -LocalMinimum::kAtMinimum) continue;
      const double at_start = std::max(0.0, pull_.multiplier[i]);
      if (!seek(at_start, end_pull_.multiplier[i], legs_.rounding_of(pull_), [&] { return end_pull_.multiplier[i]; })) return false;
      leg.released = i;
      leg.jumps = false;
      is_at_target_ = false;
    }
    return true;
  }

  // False: the centre stops where the leg begins.
  bool end_where_it_stops(DragLeg& leg) noexcept {
    const double at_end = drag_.find_excess_rate(end_pull_, motion_);
    if (!(at_end < -kMinExcessRate * speed_) || (is_at_target_ && device_comes_out_)) return true;
    const double of_direction = speed_ * kPositionRounding / std::max(end_pull_.length, OffsetDrag::kMinPull);
    if (!seek(std::max(0.0, excess_rate_), at_end, of_direction, [&] { return drag_.find_excess_rate(end_pull_, motion_); })) return false;
    if (!(length_ > 0.0)) return false;
    is_at_target_ = false;
    leg.jumps = false;
    leg.stops = true;
    leg.released = -1;
    return true;
  }

  DragOutcome make_path(DragLeg& leg) noexcept {
    leg.time = is_at_target_ ? target_time_ : std::min(end_.time, target_time_);
    if (is_at_target_ && device_comes_out_) {
      leg.released = 0;
      end_.centre = on_path(from_, to_, target_time_);
      if (!drag_.restore(end_.centre)) return DragOutcome::jumps;
    }
    leg.flow = length_;
    leg.path = CentrePath::curved(legs_.centre_, end_.centre, length_ * slope_, length_ * end_.slope);
    legs_.contacts_.guide(leg.path);
    leg.pace = {length_ * stability_, length_ * end_stability()};
    const double share = length_ > 0.0 ? middle_length_ / length_ : 0.0;
    leg.is_exact = has_one_contact() && share > 0.25 && share < 0.75 && (leg.path.at(share) - middle_.centre).norm() <= kExact &&
                   std::fabs(leg.time_at(time_, share) - middle_.time) * speed_ <= kExact;
    return DragOutcome::moves;
  }

  static constexpr double kMinNextShare = 0x1p-10;  // least share of the length that is kept at once
  static constexpr double kReleasedPull = 0x1p-24;  // a pull so short that the device counts as out of the surface

  DragLegs& legs_;
  const OffsetDrag& drag_;
  const Vec3& from_;
  const Vec3& to_;
  const double time_;  // at the start of the leg, as the next six are
  const Vec3 motion_;
  const double speed_;
  OffsetDrag::Pull pull_;
  double excess_rate_ = 0.0;
  double stability_ = 0.0;
  Vec3 slope_;
  bool device_comes_out_ = false;  // the device comes out of the surface at the target
  double target_time_ = 1.0;       // time up to which the leg may go
  double length_ = 0.0;            // of the leg, in the parameter of the flow
  double next_share_ = 0.5;        // the next length, as a share of this one
  double distance_off_cone_ =
      0.0;  // how far the centre is from the cone: contacts at a small angle make a large distance of a small tolerance
  bool is_at_target_ = false;
  OffsetDrag::Flow middle_;
  double middle_length_ = 0.0;  // the length to middle_
  OffsetDrag::Flow end_;
  double travelled_ = 0.0;     // the length to end_
  OffsetDrag::Pull end_pull_;  // at end_
};

// On curved parts the equilibrium on the cone may vanish: there the centre jumps.
DragOutcome DragLegs::make_flow_leg(const OffsetDrag& drag, const Vec3& from, const Vec3& to, double time, DragLeg& leg) noexcept {
  return FlowSearch(*this, drag, from, to, time).make(leg);
}

// Makes the leg to the point where the device comes out.
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
