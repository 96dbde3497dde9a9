#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/math/commanded_motion.h"
#include "link/haptics_source.h"
#include "link/messages.h"

namespace hapton {

// Where the objects are that programs move, for a program that has no scene file: from the moves that the haptics node announces. Frame: S.
// RT: no. Threads: one.
class KnownMoves {
 public:
  // More than any scene has. A broken haptics node may announce any numbers: objects beyond this many are left out.
  static constexpr std::size_t kMaxObjects = 1 << 16;

  // arrival: HubClient::last_arrival() of this move.
  void take(const ObjectMove& move, Arrival arrival);

  struct Placed {
    Keyframe at;             // pivot, and turn about it from the object as the scene file places it; its time_s is that of the query
    bool is_moving = false;  // its newest move ends after that time
  };
  // The place of an object at a scene time. Before its first known move, the object is where that move begins. None: not announced yet, or
  // not an object that programs may move.
  std::optional<Placed> find(std::int32_t object, double time_s) const;

  // The objects announced so far, in the order of their numbers.
  std::vector<std::int32_t> objects() const;
  // For a haptics node of an earlier build, whose moves have no name: the reply to a request by name names the object.
  void note_name(std::string_view name, std::int32_t object);
  // The name of an object; empty: not known.
  std::string_view find_name(std::int32_t object) const;
  // The objects of one name: several may share it.
  struct Named {
    std::optional<std::int32_t> object = {};  // the lowest number
    std::size_t count = 0;
  };
  Named find_named(std::string_view name) const;

 private:
  static CommandedMotion begin_motion(const ObjectMove& first);

  HapticsSource source_;
  std::map<std::int32_t, CommandedMotion> motions_;  // by object
  std::map<std::int32_t, std::string> names_;        // likewise
};

}  // namespace hapton
