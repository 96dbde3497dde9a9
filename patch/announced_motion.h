#pragma once

#include <algorithm>

#include "core/math/commanded_motion.h"

namespace hapton {

// The motion of a body by commanded moves, on the device side, which learns of each move some time after it was decided. A move that is
// known before it begins is made exactly, to the last bit: haptics, pictures and this side have the body at one place. For one that
// comes later, because its datagrams were lost, the body goes from where it is to the same end, at the same time, or as soon after it as
// kMaxSurfaceSpeed allows. So the body never jumps, and at the end of this motion it is where haptics and the pictures have it.
// Frame: S. Units: SI. RT: yes. Threads: one.
class AnnouncedMotion {
 public:
  AnnouncedMotion() = default;
  // pivot_S: a point of the body at rest; no point of the body is farther from this one than radius_m.
  AnnouncedMotion(const Vec3& pivot_S, double radius_m) noexcept : motion_(pivot_S), radius_m_(radius_m) {}

  // Takes a newer move as it is, while nothing is felt. If earlier moves are missing, the body is assumed at rest at the start of the first
  // known move. False: it is not newer.
  bool accept(const CommandedMove& move) noexcept {
    if (move.serial <= serial()) return false;
    if (serial() == 0 && move.serial > 1) {
      CommandedMove before{.serial = move.serial - 1, .from = move.from, .to = move.from};
      before.from.time_s = before.to.time_s = -1.0;
      motion_.begin(before);
    }
    return motion_.begin(move);
  }

  // Takes a newer move while the body is felt. False: it is not newer. now_s: scene time of the last step.
  bool accept_in_contact(const CommandedMove& move, double now_s) noexcept {
    if (move.serial <= serial()) return false;
    const bool is_as_announced = now_s <= move.from.time_s && is_same_place(motion_.keyframe_at(move.from.time_s), move.from) &&
                                 compute_move_time_s(move.from, move.to, 0.0, radius_m_, kMaxSurfaceSpeed) <= announced_duration_s(move);
    if (is_as_announced) return motion_.begin(move);
    const double begin_s = std::max(now_s, move.from.time_s);
    const double left_s = std::max(move.to.time_s - begin_s, 0.0);
    CommandedMove late_move = make_move(motion_, move.serial, begin_s, move.to, left_s, radius_m_, kMaxSurfaceSpeed);
    ++late_;
    return motion_.begin(late_move);
  }

  Pose pose_at(double time_s) const noexcept { return motion_.pose_at(time_s); }
  std::uint32_t serial() const noexcept { return motion_.newest().serial; }
  // The number of moves that did not go as announced.
  std::uint64_t late() const noexcept { return late_; }

 private:
  static constexpr double kRounding = 1e-9;  // share of the body's size, or of the time

  bool is_same_place(const Keyframe& a, const Keyframe& b) const noexcept {
    return most_travel_m(a, b, radius_m_) <= kRounding * radius_m_ + 0x1p-50 * a.p_S.norm();
  }
  // With a margin: the nanoseconds of a message are rounded.
  static double announced_duration_s(const CommandedMove& move) noexcept {
    return (move.to.time_s - move.from.time_s) * (1.0 + 1e-6) + 2e-9;
  }

  CommandedMotion motion_{Vec3::Zero()};
  double radius_m_ = 0.0;
  std::uint64_t late_ = 0;
};

}  // namespace hapton
