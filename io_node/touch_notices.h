#pragma once

#include <utility>

#include "io_node/event_ring.h"
#include "io_node/patch_link.h"

namespace hapton {

// Tells the log where the force is computed: one event when parts of the scene are requested, when the force is first computed from them,
// and when it comes from the haptics node again. While no haptics node is connected, the first and the last of these are left out: the log
// has already said that the node left. RT: yes. Threads: one.
class TouchNotices {
 public:
  // Call in each cycle. is_local: io_node computed the force of the newest sample. Calls notify(event) for each event.
  template <class Notify>
  void check(const PatchLink& link, bool is_local, bool has_haptics, Notify&& notify) noexcept {
    if (const bool was_wanted = std::exchange(is_wanted_, link.is_wanted()); was_wanted != is_wanted_ && has_haptics) {
      notify(make(is_wanted_ ? ServoEvent::Kind::parts_requested : ServoEvent::Kind::force_from_haptics, link.round_trip_s()));
    }
    if (!is_wanted_) has_notified_local_ = false;
    if (!is_wanted_ || !is_local || has_notified_local_) return;
    has_notified_local_ = true;
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
  bool has_notified_local_ = false;
};

}  // namespace hapton
