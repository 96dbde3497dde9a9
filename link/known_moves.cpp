#include "link/known_moves.h"

#include "link/commanded_move.h"

namespace hapton {

// Forgets everything at the first move of another haptics process, because that process may have another scene.
void KnownMoves::take(const ObjectMove& move, Arrival arrival) {
  const HapticsSource::Verdict verdict = source_.note(move, arrival);
  if (verdict == HapticsSource::Verdict::old) return;
  if (verdict == HapticsSource::Verdict::other) {
    motions_.clear();
    names_.clear();
  }
  if (move.name[0] != '\0' && find_name(move.object) != move.name.data()) note_name(move.name.data(), move.object);
  const auto known = motions_.find(move.object);
  if (known != motions_.end()) {
    known->second.begin(to_command(move));
  } else if (motions_.size() < kMaxObjects) {
    motions_.emplace(move.object, begin_motion(move));
  }
}

void KnownMoves::note_name(std::string_view name, std::int32_t object) {
  if (names_.size() < kMaxObjects || names_.contains(object)) names_.insert_or_assign(object, std::string(name));
}

// Where the object was before its first known move is unknown: it counts as at rest at that move's start since before scene time 0.
CommandedMotion KnownMoves::begin_motion(const ObjectMove& first) {
  const CommandedMove move = to_command(first);
  CommandedMotion motion(move.from.p_S);
  if (move.serial > 1) {
    CommandedMove before{.serial = move.serial - 1, .from = move.from, .to = move.from};
    before.from.time_s = before.to.time_s = -1.0;
    motion.begin(before);
  }
  motion.begin(move);
  return motion;
}

std::optional<KnownMoves::Placed> KnownMoves::find(std::int32_t object, double time_s) const {
  const auto known = motions_.find(object);
  if (known == motions_.end()) return std::nullopt;
  const CommandedMotion& motion = known->second;
  Placed placed{.at = motion.keyframe_at(time_s), .is_moving = motion.newest().serial > 0 && time_s < motion.newest().to.time_s};
  placed.at.time_s = time_s;
  return placed;
}

std::vector<std::int32_t> KnownMoves::objects() const {
  std::vector<std::int32_t> numbers;
  for (const auto& [object, motion] : motions_) numbers.push_back(object);
  return numbers;
}

std::string_view KnownMoves::find_name(std::int32_t object) const {
  const auto known = names_.find(object);
  return known != names_.end() ? std::string_view(known->second) : std::string_view();
}

KnownMoves::Named KnownMoves::find_named(std::string_view name) const {
  Named named;
  for (const auto& [object, known] : names_) {
    if (known != name) continue;
    if (++named.count == 1) named.object = object;
  }
  return named;
}

}  // namespace hapton
