#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "core/math/commanded_motion.h"
#include "link/messages.h"
#include "link/move_source.h"

namespace hapton {

// Where the objects are that programs move, for a program without the scene file: from what the haptics node announces. Frame: S. RT: no.
// Threads: one.
class KnownMoves {
 public:
  // arrival: as HubClient::last_arrival of this move.
  void take(const ObjectMove& move, Arrival arrival);

  struct Placed {
    Keyframe at;             // pivot, and turn about it from the object as the scene file places it; its time is the one given
    bool is_moving = false;  // its newest move ends later
  };
  // At a scene time. Before the first move that is known, the object is where that one began. None: not announced yet, or not an object
  // that programs may move.
  std::optional<Placed> find(std::int32_t object, double time_s) const;

  // No message has the names of objects, but the reply to a request by name has the number.
  void note_name(std::string_view name, std::int32_t object) { numbers_.insert_or_assign(std::string(name), object); }
  std::optional<std::int32_t> find_number(std::string_view name) const;

 private:
  static CommandedMotion begin_motion(const ObjectMove& first);

  MoveSource source_;
  std::map<std::int32_t, CommandedMotion> motions_;  // by object
  std::map<std::string, std::int32_t, std::less<>> numbers_;
};

}  // namespace hapton
