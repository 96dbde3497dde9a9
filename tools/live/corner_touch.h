#pragma once

#include <cstdint>
#include <deque>

#include "link/messages.h"

namespace hapton {

// Finds the points that a person touches with the tip of the stylus, from the samples of the hub: the mean position over a period in which
// the tip is still, with or without the press of a button. Without a press the tip must first have moved away from the last point or from
// its first position, so that a stylus in its stand or a resting hand does not count as touch. Frame W. RT: no. Threads: one.
class CornerTouch {
 public:
  // Without a press the tip must stay within kHoldStillM of its mean for kHoldS. A hand in the air drifts farther, one on a screen less.
  // All values are free choices.
  static constexpr double kHoldS = 1.0;
  static constexpr double kHoldStillM = 0.0005;
  // After a press, the mean is over kPressS, by which time the motion due to the press has ended.
  static constexpr double kPressS = 0.3;
  static constexpr double kPressStillM = 0.001;
  // The way from the last touched point before a touch without a press; screens are larger.
  static constexpr double kMinTravelM = 0.02;

  enum class Event : std::uint8_t {
    none,
    touched,
    moved,  // after a press the tip moved farther than kPressStillM from the mean: no touch
  };

  // Takes the next sample; one that is not newer than the last, or not finite, is ignored.
  Event add(const ProbeState& probe);

  // The mean, and the largest distance from it, of the event that the last call of add returned. Pre: it was not `none`.
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

  std::deque<Sample> samples_;  // the samples of the last kHoldS
  bool has_started_ = false;
  std::int64_t last_sample_ns_ = 0;
  std::uint32_t last_buttons_ = 0;
  std::int64_t press_ns_ = 0;  // 0: not pressed
  Vec3 p_WB_ = Vec3::Zero();   // the point B from which the tip must move away
  bool has_moved_away_ = false;
  Vec3 p_W_ = Vec3::Zero();
  double moved_m_ = 0.0;
};

}  // namespace hapton
