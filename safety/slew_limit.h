#pragma once

#include "safety/vector_limit.h"

namespace hapton {

// A vector that follows a goal with limited haste, within a ball that may shrink: first it comes into the ball, as fast as letting go may
// be; what is left of its haste goes towards the goal. So however the goal turns, the ball is kept as soon as letting go allows. Units: its
// own, and so much in this step. RT: yes.
class SlewLimit {
 public:
  struct Haste {
    double towards_goal = 0.0;
    double letting_go = 0.0;  // >= towards_goal
  };

  // Pre: finite; ball >= 0. Post: value() has changed by no more than the larger haste, and value() <= ball, or it has let go with all its
  // haste.
  const Vec3& follow(const Vec3& goal, double ball, const Haste& haste) noexcept {
    double left = haste.towards_goal;
    const double length = length_of(value_);
    if (length > ball) {
      const double shrink = std::fmin(length - ball * kJustBelow, haste.letting_go);
      // Within rounding of zero is zero.
      value_ = length - shrink <= 1e-12 * length ? Vec3(Vec3::Zero()) : Vec3(value_ * ((length - shrink) / length));
      left = std::fmax(left - shrink, 0.0);
    }
    const Vec3 aim = shortened(goal, ball);
    const Vec3 way = aim - value_;
    const double way_length = length_of(way);
    was_cut_ = way_length > left / kJustBelow;
    value_ = was_cut_ ? Vec3(value_ + way * (left / way_length * kJustBelow)) : aim;
    return value_;
  }

  const Vec3& value() const noexcept { return value_; }
  bool was_cut() const noexcept { return was_cut_; }

 private:
  Vec3 value_ = Vec3::Zero();
  bool was_cut_ = false;
};

}  // namespace hapton
