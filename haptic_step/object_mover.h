#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "haptic_step/haptics_step.h"
#include "link/messages.h"
#include "scene/scene_file.h"

namespace hapton {

// Carries out the requests of programs to move objects with `moved_by = "program"`. A request becomes a move that begins at the pose of the
// object at the scene time of the last reply, so that the next reply continues without a jump. No point of an object moves faster than
// kMaxSurfaceSpeed: a move that would be faster takes longer than requested, and the reply says so.
//
// A flood costs little: request() only keeps the request, one for each object, kMaxWaiting at most; carry_out() carries out one, and its
// caller sets the pace. RT: request and carry_out yes. Threads: the step's.
class ObjectMover {
 public:
  static constexpr std::size_t kMaxWaiting = 16;  // requests, each for another object; one is carried out every 4 ms (decision 155)
  // The most moves of one object that begin later than now: the other half of the moves that CommandedMotion keeps is for the past.
  static constexpr std::int64_t kMaxFutureMoves = CommandedMotion::kMoves / 2;
  static constexpr std::size_t kMaxReplies = 128;  // replies kept, so many that a sender repeats a request before its reply is dropped

  // source: as in ObjectMove.
  ObjectMover(const Scene& scene, std::uint32_t source);
  ObjectMover(const ObjectMover&) = delete;
  ObjectMover& operator=(const ObjectMover&) = delete;

  // Keeps a request to be carried out. It replaces an earlier one for the same object that still waits, which is rejected. If kMaxWaiting
  // wait already, it is counted and left out; its sender repeats it. A request that was carried out before only gets its reply again.
  void request(const MoveRequest& request) noexcept;
  bool has_request() const noexcept { return waiting_count_ > 0; }
  // Moves begin this much later than the last reply: while the hub computes the force, it has to know of a move before the move begins.
  // Moves of one object then begin at least lead_ns / kMaxFutureMoves apart, so that at most kMaxFutureMoves of them have not begun; a
  // newer request waits until it may, and replaces the one that waits.
  void set_lead_ns(std::int64_t lead_ns) noexcept { lead_ns_ = lead_ns; }

  // Carries out the request that has waited longest of those that may begin. If none may, the reply has the request number 0. move: the
  // object's new move, for all who draw it; none if the request was rejected or has been carried out before. Pre: has_request().
  struct Outcome {
    MoveReply reply;
    std::optional<ObjectMove> move;
  };
  Outcome carry_out(HapticsStep& step) noexcept;

  // The newest move of each object that programs may move, in the order of the scene; serial 0: not moved yet.
  std::span<const ObjectMove> moves() const noexcept { return moves_; }
  // The number of requests left out because too many waited.
  std::uint64_t overflows() const noexcept { return overflows_; }
  std::string_view name_of(std::int32_t object) const noexcept;

 private:
  struct Waiting {
    MoveRequest request;
    std::int32_t object = -1;  // number in the scene; -1: no object, or several, have that name
  };
  struct Found {
    std::int32_t object = -1;
    std::size_t count = 0;  // number of objects with that name
  };

  Found find(const MoveRequest& request) const noexcept;
  bool may_begin(const Waiting& waiting, std::int64_t start_ns) const noexcept;
  void move(HapticsStep& step, const Waiting& waiting, Outcome& outcome) noexcept;
  void reject_unknown(const MoveRequest& request, HapticsSetup::Text& rejection) const noexcept;
  const MoveReply* find_reply(std::uint32_t request) const noexcept;
  void add_reply(const MoveReply& reply) noexcept;
  void reject_overtaken(const Waiting& waiting) noexcept;

  std::vector<std::string> names_;                                  // of all objects, in the order of the scene
  std::vector<std::pair<std::string_view, std::int32_t>> by_name_;  // sorted
  std::vector<std::shared_ptr<const CommandedObject>> objects_;     // in the order of the scene; null: programs may not move it
  std::vector<ObjectMove> moves_;
  std::array<Waiting, kMaxWaiting> waiting_ = {};  // the first has waited longest
  std::size_t waiting_count_ = 0;
  std::array<MoveReply, kMaxReplies> replies_ = {};  // the newest, a ring
  std::size_t next_reply_ = 0;
  std::uint64_t overflows_ = 0;
  std::int64_t lead_ns_ = 0;
};

}  // namespace hapton
