#pragma once

#include "safety/vector_limit.h"

namespace hapton {

// A vector that follows a goal at a limited rate, within a magnitude limit that may shrink. In each step it first comes within the limit,
// at the release rate; the rest of the step goes towards the goal. So the limit holds as soon as the release rate allows, wherever the goal
// is. Units: those of the vector; rates are per step. RT: yes.
class SlewLimit {
 public:
  struct Rates {
    double towards_goal = 0.0;  // largest change in a step towards the goal
    double release = 0.0;       // largest decrease in a step that begins above the limit; >= towards_goal
  };

  // One step. Pre: finite; limit >= 0. Post: value() has changed by no more than the larger rate; |value()| <= limit, or it decreased by
  // the release rate.
  const Vec3& follow(const Vec3& goal, double limit, const Rates& rates) noexcept {
    double change_left = rates.towards_goal;
    const double length = length_of(value_);
    if (length > limit) {
      const double shrink = std::fmin(length - limit * kJustBelow, rates.release);
      // A remainder that is only rounding error becomes zero.
      value_ = length - shrink <= 1e-12 * length ? Vec3(Vec3::Zero()) : Vec3(value_ * ((length - shrink) / length));
      change_left = std::fmax(change_left - shrink, 0.0);
    }
    const Vec3 limited_goal = shortened(goal, limit);
    const Vec3 change = limited_goal - value_;
    const double change_length = length_of(change);
    was_limited_ = change_length > change_left / kJustBelow;
    value_ = was_limited_ ? Vec3(value_ + change * (change_left / change_length * kJustBelow)) : limited_goal;
    return value_;
  }

  const Vec3& value() const noexcept { return value_; }
  bool was_limited() const noexcept { return was_limited_; }  // the last step did not reach the goal

 private:
  Vec3 value_ = Vec3::Zero();
  bool was_limited_ = false;
};

}  // namespace hapton
