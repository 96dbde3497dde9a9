#pragma once

#include <cstdint>
#include <deque>

#include "link/messages.h"

namespace hapton {

// Finds the points that a person touches with the tip of the stylus, from the samples of the hub: the mean over a period in which the tip
// is still, after a press of any button or without one. Without a press the tip must have moved away first, from the last point or from
// where it was at the beginning, so that a stylus in its stand and a hand that rests do not count as touch. Frame W. RT: no.
class CornerTouch {
 public:
  // A hand held in the air drifts farther in that time; one that leans on a screen does not.
  static constexpr double kHoldS = 1.0;
  static constexpr double kHoldStillM = 0.0005;
  // A press moves the tip itself; it is over by then.
  static constexpr double kPressS = 0.3;
  static constexpr double kPressStillM = 0.001;
  static constexpr double kAwayM = 0.02;

  enum class Event : std::uint8_t {
    none,
    touched,
    moved,  // after a press: more than kPressStillM from the mean
  };

  // Pre: samples in their order; an older one, or one that is not finite, is ignored.
  Event add(const ProbeState& probe);

  // Of the last event: the mean, and the largest distance from it.
  const Vec3& p_W() const { return p_W_; }
  double moved_m() const { return moved_m_; }

 private:
  struct Sample {
    std::int64_t time_ns;
    Vec3 p_WD;
  };

  Event decide(std::int64_t now_ns);
  void measure(std::int64_t from_ns);
  Event finish(Event event);

  std::deque<Sample> samples_;  // of the last kHoldS
  bool has_started_ = false;
  std::int64_t last_ns_ = 0;
  std::uint32_t last_buttons_ = 0;
  std::int64_t press_ns_ = 0;  // 0: not pressed
  Vec3 p_WB_ = Vec3::Zero();   // where the tip must move away from
  bool was_away_ = false;
  Vec3 p_W_ = Vec3::Zero();
  double moved_m_ = 0.0;
};

}  // namespace hapton
