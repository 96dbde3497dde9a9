#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "link/messages.h"

namespace hapton {

// Keeps the newest move of each object that programs move, the last few moves of all objects, and which serials have come, all of one
// haptics process: for a hub that computes forces itself. The room is bounded: nothing is kept of further objects; a scene with so many
// is not offered in parts. RT: yes. Threads: one.
class MoveTable {
 public:
  // False: it is known already, older than what is known, not valid (serial 0, no unit quaternion), or there is no room for its object.
  bool take(const ObjectMove& move) noexcept {
    if (move.source != source_) {
      *this = {};
      source_ = move.source;
    }
    const auto is_unit = [](const Quat& q) { return std::abs(q.norm() - 1.0) <= 1e-9; };
    if (move.serial == 0 || !is_unit(move.from_q) || !is_unit(move.to_q)) return false;
    note(move.serial);
    const auto end = moves_.begin() + static_cast<std::ptrdiff_t>(count_);
    auto known = std::find_if(moves_.begin(), end, [&](const ObjectMove& one) { return one.object == move.object; });
    if (known == moves_.end() || (known != end && known->serial >= move.serial)) return false;
    if (known == end) ++count_;
    *known = move;
    recent_[recent_count_++ % kRecent] = move;
    return true;
  }
  void clear() noexcept { *this = {}; }

  std::span<const ObjectMove> moves() const noexcept { return std::span(moves_).first(count_); }
  // Calls visit(move) for the last kRecent moves that were taken, the oldest first.
  template <class Visit>
  void visit_recent(Visit&& visit) const {
    for (std::size_t n = recent_count_ - std::min(recent_count_, kRecent); n < recent_count_; ++n) visit(recent_[n % kRecent]);
  }
  // The newest move of an object; null: none is known.
  const ObjectMove* find(std::int32_t object) const noexcept {
    for (const ObjectMove& one : moves()) {
      if (one.object == object) return &one;
    }
    return nullptr;
  }
  // The values for PatchStatus::newest_move and PatchStatus::moves_received.
  std::uint32_t newest() const noexcept { return newest_; }
  std::uint64_t received() const noexcept { return received_; }

 private:
  static constexpr std::size_t kRecent = 16;  // moves that a newly announced body is given

  void note(std::uint32_t serial) noexcept {
    if (serial > newest_) {
      const std::uint32_t passed = serial - newest_;
      received_ = passed < 64 ? received_ << passed : 0;
      newest_ = serial;
    }
    if (const std::uint32_t back = newest_ - serial; back < 64) received_ |= std::uint64_t{1} << back;
  }

  std::uint32_t source_ = 0;
  std::uint32_t newest_ = 0;
  std::uint64_t received_ = 0;
  std::size_t count_ = 0;
  std::array<ObjectMove, PatchBody::kMaxBodies> moves_ = {};
  std::size_t recent_count_ = 0;
  std::array<ObjectMove, kRecent> recent_ = {};
};

}  // namespace hapton
