#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/math/commanded_motion.h"
#include "link/messages.h"
#include "link/move_source.h"

namespace hapton {

// Where the objects are that programs move, for a program without the scene file: from what the haptics node announces. Frame: S. RT: no.
// Threads: one.
class KnownMoves {
 public:
  // More than any scene has: a broken haptics node may announce any numbers, and others are left out.
  static constexpr std::size_t kMaxObjects = 1 << 16;

  // arrival: as HubClient::last_arrival of this move.
  void take(const ObjectMove& move, Arrival arrival);

  struct Placed {
    Keyframe at;             // pivot, and turn about it from the object as the scene file places it; its time is the one given
    bool is_moving = false;  // its newest move ends later
  };
  // At a scene time. Before the first move that is known, the object is where that one began. None: not announced yet, or not an object
  // that programs may move.
  std::optional<Placed> find(std::int32_t object, double time_s) const;

  // Announced so far, in the order of their numbers.
  std::vector<std::int32_t> objects() const;
  // Moves announce the name; a haptics node of an earlier build does not, but its reply to a request by name has the number.
  void note_name(std::string_view name, std::int32_t object);
  // Empty: not known.
  std::string_view find_name(std::int32_t object) const;
  // Objects may share a name.
  struct Named {
    std::optional<std::int32_t> object = {};  // the first one
    std::size_t count = 0;
  };
  Named find_named(std::string_view name) const;

 private:
  static CommandedMotion begin_motion(const ObjectMove& first);

  MoveSource source_;
  std::map<std::int32_t, CommandedMotion> motions_;  // by object
  std::map<std::int32_t, std::string> names_;        // likewise
};

}  // namespace hapton
