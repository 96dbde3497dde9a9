#include "io_node/peer_notices.h"

namespace hapton {

void PeerNotices::note(const PeerEvent& event) noexcept {
  switch (event.kind) {
    case PeerEvent::Kind::none:
    case PeerEvent::Kind::message:
      return;
    case PeerEvent::Kind::joined:
      return push(ServoEvent::Kind::joined, event.role, peers_.peer(event.peer).address);
    case PeerEvent::Kind::left:
      return push(ServoEvent::Kind::left, event.role, peers_.peer(event.peer).address);
    case PeerEvent::Kind::rejected:
      if (rejections_.is_due(event.role, event.receive_time_ns)) push(ServoEvent::Kind::rejected, event.role, {});
      return;
  }
}

void PeerNotices::check(std::int64_t now_ns) noexcept {
  if (const auto flood = peers_.take_flood(now_ns)) {
    ServoEvent event{ServoEvent::Kind::flood, NodeRole::tool, flood->from, flood->per_second, {}, {}};
    event.flood = flood->rejection;
    event.is_from_several = flood->is_from_several;
    event.is_mostly_filtered = flood->is_mostly_filtered;
    events_.push(event);
  }
  unknown_.check(peers_.seal_counts(), peers_.counts(), now_ns, [&](ServoEvent::Kind kind) { push(kind, NodeRole::tool, {}); });
}

}  // namespace hapton
