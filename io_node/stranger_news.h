#pragma once

#include <cstdint>

#include "io_node/event_ring.h"
#include "link/hub_peers.h"
#include "link/seal_counts.h"
#include "runtime/clock.h"

namespace hapton {

// Who lacks the key, the version or the right to a role is told nothing; the person at the hub is, every ten seconds at most.
// RT: yes. Threads: one.
class StrangerNews {
 public:
  static constexpr std::int64_t kEveryNs = 10 * kNanosecondsPerSecond;

  // Calls tell(kind) for each kind that came since the last time that this looked.
  template <class Tell>
  void look(const SealCounts& seal, const HubCounts& hub, std::int64_t now_ns, Tell&& tell) noexcept {
    if (now_ns < next_ns_) return;
    const auto tell_if = [&](std::uint64_t count, std::uint64_t& told, ServoEvent::Kind kind) {
      if (count == told) return;
      told = count;
      next_ns_ = now_ns + kEveryNs;
      tell(kind);
    };
    tell_if(seal.wrong_key, wrong_key_, ServoEvent::Kind::wrong_key);
    tell_if(seal.wrong_version, wrong_version_, ServoEvent::Kind::wrong_version);
    tell_if(hub.role_violations, role_violations_, ServoEvent::Kind::role_violation);
  }

 private:
  std::uint64_t wrong_key_ = 0;
  std::uint64_t wrong_version_ = 0;
  std::uint64_t role_violations_ = 0;
  std::int64_t next_ns_ = 0;
};

}  // namespace hapton
