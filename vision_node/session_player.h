#pragma once

#include <cstdint>

namespace hapton {

// The moment of a recording that is shown: it moves on with a clock, at a chosen speed, from the recording's beginning to its end, where it
// stops. Units: seconds of the recording; ns of any one monotonic clock. RT: no.
class SessionPlayer {
 public:
  static constexpr double kSlowest = 0.1;  // times the speed of the recording; this and the next: free choices
  static constexpr double kFastest = 8.0;

  // Pre: begin_s <= end_s.
  SessionPlayer(double begin_s, double end_s);

  // Moves on by the time since the last call. True: the moment has changed.
  bool advance(std::int64_t now_ns);
  // Moves to that time, or to the nearest one that the recording has. A number that is not finite changes nothing.
  void seek(double t_s);
  // Pauses, or plays on; at the end, plays again from the beginning.
  void toggle_pause();
  void pause() { is_paused_ = true; }
  // Holds the moment, paused or not, while the time line is dragged.
  void hold(bool is_held) { is_held_ = is_held; }
  // Sets the next higher, or lower, speed of 0.1, 0.25, 0.5, 1, 2, 4 and 8.
  void speed_up();
  void slow_down();
  // Pre: speed is from kSlowest to kFastest.
  void set_speed(double speed) { speed_ = speed; }

  double moment_s() const { return moment_s_; }
  double begin_s() const { return begin_s_; }
  double end_s() const { return end_s_; }
  double speed() const { return speed_; }
  bool is_paused() const { return is_paused_; }

 private:
  double begin_s_;
  double end_s_;
  double moment_s_;
  double speed_ = 1.0;
  bool is_paused_ = false;
  bool is_held_ = false;
  std::int64_t last_ns_ = -1;  // below 0: not advanced yet
};

}  // namespace hapton
