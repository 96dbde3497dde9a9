#include "core/math/commanded_motion.h"

#include <algorithm>

namespace hapton {
namespace {

// The keyframe of the move at this time: exactly `from` until the move begins, and exactly `to` from its end on.
Keyframe keyframe_of(const CommandedMove& move, double time_s) noexcept {
  if (time_s >= move.to.time_s) return move.to;
  if (time_s <= move.from.time_s) return move.from;
  return keyframe_between(move.from, move.to, (time_s - move.from.time_s) / (move.to.time_s - move.from.time_s));
}

}  // namespace

CommandedMotion::CommandedMotion(const Vec3& pivot_S) noexcept : pivot_S_(pivot_S) { moves_[0].from.p_S = moves_[0].to.p_S = pivot_S; }

bool CommandedMotion::begin(const CommandedMove& move) noexcept {
  if (move.serial <= newest().serial) return false;
  if (newest().serial == 0 || move.from.time_s > newest().from.time_s) {
    newest_ = (newest_ + 1) % kMoves;
    count_ = std::min(count_ + 1, kMoves);
  }
  moves_[newest_] = move;
  return true;
}

const CommandedMove& CommandedMotion::move_at(double time_s) const noexcept {
  const auto before_newest = [&](std::size_t back) -> const CommandedMove& { return moves_[(newest_ + kMoves - back) % kMoves]; };
  for (std::size_t back = 0; back + 1 < count_; ++back) {
    if (before_newest(back).from.time_s < time_s) return before_newest(back);
  }
  return before_newest(count_ - 1);
}

Keyframe CommandedMotion::keyframe_at(double time_s) const noexcept { return keyframe_of(move_at(time_s), time_s); }

double compute_move_time_s(const Keyframe& from, const Keyframe& to, double requested_s, double radius_m, double most_m_per_s) noexcept {
  return std::max(requested_s, most_travel_m(from, to, radius_m) / most_m_per_s);
}

CommandedMove make_move(const CommandedMotion& motion, std::uint32_t serial, double time_s, const Keyframe& to, double requested_s,
                        double radius_m, double most_m_per_s) noexcept {
  CommandedMove move{.serial = serial, .from = motion.keyframe_at(time_s), .to = to};
  move.from.time_s = time_s;
  move.to.time_s = time_s + compute_move_time_s(move.from, to, requested_s, radius_m, most_m_per_s);
  return move;
}

}  // namespace hapton
