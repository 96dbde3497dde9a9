#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/math/keyframe_motion.h"

namespace hapton {

// Largest speed of a surface that moves by itself, m/s: the reduced speed of ISO 10218-1 for robots beside people.
constexpr double kMaxSurfaceSpeed = 0.25;

// A move of a rigid body that a program commanded: from one pose to another, interpolated as between keyframes; at rest after it.
struct CommandedMove {
  std::uint32_t serial = 0;  // counts the moves of all bodies, from 1; 0: no move, the body is where it was at the start
  Keyframe from;
  Keyframe to;
};

// The motion of a rigid body by commanded moves, each of which takes over from the one before. The moves and the time alone determine the
// pose: at each time it is that of the newest move that started before; before the first move the body is at rest. Only the newest kMoves
// are kept; the rest pose at the start counts as a move. Pre: fewer than kMoves moves begin at or after the time of a query. ObjectMover
// guarantees that for moves that are announced ahead of time. Frame: S. RT: yes. Threads: any for const calls.
class CommandedMotion {
 public:
  // Twice the number of moves that ObjectMover announces ahead of time, so that the move in effect is always kept.
  static constexpr std::size_t kMoves = 64;

  // pivot_S: the position of the pivot while the body is at rest.
  explicit CommandedMotion(const Vec3& pivot_S) noexcept;

  // Adds a newer move. If it starts no later than the newest one, it replaces that one. False: its serial is not newer; nothing changed.
  // Pre: unit quaternions, finite numbers, `to` not earlier than `from`.
  bool begin(const CommandedMove& move) noexcept;

  // X_SO at that time: it takes each point of the body from its position at rest to its present one.
  Pose pose_at(double time_s) const noexcept { return pose_of(keyframe_at(time_s), pivot_S_); }
  // The same as a keyframe: position of the pivot, and rotation about it. Its time_s is undefined.
  Keyframe keyframe_at(double time_s) const noexcept;

  const Vec3& pivot() const noexcept { return pivot_S_; }
  const CommandedMove& newest() const noexcept { return moves_[newest_]; }

 private:
  // The move that determines the pose at that time.
  const CommandedMove& move_at(double time_s) const noexcept;

  Vec3 pivot_S_;
  std::array<CommandedMove, kMoves> moves_;  // ring buffer
  std::size_t newest_ = 0;
  std::size_t count_ = 1;
};

// The duration of a move, s: as requested, or longer so that no point of the body is faster than most_m_per_s. radius_m: the largest
// distance of a point of the body from the pivot. Pre: requested_s is 0 or more, most_m_per_s is above 0. RT: yes.
double compute_move_time_s(const Keyframe& from, const Keyframe& to, double requested_s, double radius_m, double most_m_per_s) noexcept;

// A move that begins at time_s, at the pose that the motion has then, ends at `to` and takes compute_move_time_s. RT: yes.
CommandedMove make_move(const CommandedMotion& motion, std::uint32_t serial, double time_s, const Keyframe& to, double requested_s,
                        double radius_m, double most_m_per_s) noexcept;

}  // namespace hapton
