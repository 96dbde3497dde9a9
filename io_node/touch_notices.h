#pragma once

#include <utility>

#include "io_node/event_ring.h"
#include "io_node/patch_link.h"

namespace hapton {

// Where the force is computed, for the log: one line when parts of the scene are requested, when the force is first computed from them, and
// when it comes from the haptics node again. None while there is no haptics node: the log has that it left. RT: yes. Threads: one.
class TouchNotices {
 public:
  // is_local: the newest sample's force was computed here. Calls notify(event) for each.
  template <class Notify>
  void check(const PatchLink& link, bool is_local, bool has_haptics, Notify&& notify) noexcept {
    if (const bool was_wanted = std::exchange(is_wanted_, link.is_wanted()); was_wanted != is_wanted_ && has_haptics) {
      notify(make(is_wanted_ ? ServoEvent::Kind::parts_requested : ServoEvent::Kind::force_from_haptics, link.round_trip_s()));
    }
    if (!is_wanted_) is_told_ = false;
    if (!is_wanted_ || !is_local || is_told_) return;
    is_told_ = true;
    notify(make(ServoEvent::Kind::force_from_parts, link.round_trip_s()));
  }

 private:
  static ServoEvent make(ServoEvent::Kind kind, double round_trip_s) noexcept {
    ServoEvent event;
    event.kind = kind;
    event.role = NodeRole::haptics;
    event.round_trip_s = round_trip_s;
    return event;
  }

  bool is_wanted_ = false;
  bool is_told_ = false;
};

}  // namespace hapton
