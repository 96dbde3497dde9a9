#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/math/keyframe_motion.h"

namespace hapton {

// Largest speed of a surface that moves by itself, m/s: the reduced speed of ISO 10218-1 for robots beside people.
constexpr double kMaxSurfaceSpeed = 0.25;

// A move of a rigid body that a program commanded: from one pose to another, interpolated linearly as between keyframes; at rest after it.
struct CommandedMove {
  std::uint32_t serial = 0;  // counts the moves of all bodies, from 1; 0: none, the body is as at the start
  Keyframe from;
  Keyframe to;
};

// The motion of a rigid body by commanded moves, each of which takes over from the one before. Whoever knows the moves can compute the pose
// from the time alone: at each time the newest move that started before it determines the pose; before the first move the body is at rest.
// Only the newest kMoves are kept; the rest pose at the start counts as a move. Pre: fewer than kMoves moves begin after the time of a
// query. ObjectMover guarantees that for moves that are announced ahead of time. Frame: S. RT: yes. Threads: const calls from any number.
class CommandedMotion {
 public:
  // Twice the number of moves that ObjectMover announces ahead of time, so that the move in effect is always kept.
  static constexpr std::size_t kMoves = 64;

  // pivot_S: on the body at rest.
  explicit CommandedMotion(const Vec3& pivot_S) noexcept;

  // Adds a newer move. If it starts no later than the newest one, it replaces that one. False: its serial is not newer; nothing changed.
  // Pre: unit quaternions, finite numbers, `to` not earlier than `from`.
  bool begin(const CommandedMove& move) noexcept;

  // X_SO at that time: it moves the points of the body at rest.
  Pose pose_at(double time_s) const noexcept { return pose_of(keyframe_at(time_s), pivot_S_); }
  // The same as a keyframe: position of the pivot, and rotation about it. Its time_s is not set.
  Keyframe keyframe_at(double time_s) const noexcept;

  const Vec3& pivot() const noexcept { return pivot_S_; }
  const CommandedMove& newest() const noexcept { return moves_[newest_]; }

 private:
  // The move in effect at that time.
  const CommandedMove& move_at(double time_s) const noexcept;

  Vec3 pivot_S_;
  std::array<CommandedMove, kMoves> moves_;  // ring buffer
  std::size_t newest_ = 0;
  std::size_t count_ = 1;
};

// Duration of a move, s: as requested, or longer so that no point of the body is faster than most_m_per_s. radius_m: largest distance of a
// point of the body from the pivot. Pre: requested_s 0 or more, most_m_per_s above 0. RT: yes.
double compute_move_time_s(const Keyframe& from, const Keyframe& to, double requested_s, double radius_m, double most_m_per_s) noexcept;

// A move from where the motion is at time_s to `to`, which takes compute_move_time_s. RT: yes.
CommandedMove make_move(const CommandedMotion& motion, std::uint32_t serial, double time_s, const Keyframe& to, double requested_s,
                        double radius_m, double most_m_per_s) noexcept;

}  // namespace hapton
