#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "link/key_role.h"

namespace hapton {

// The greatest timestamp that a hub has seen in a handshake, by role and sending host: a handshake that is not later is a replay.
// Timestamps are the host's CLOCK_MONOTONIC, which never goes back while the host identity (host_id.h) stays the same. Each role has kHosts
// entries of its own, so that the holder of one role's key cannot displace another role's hosts; when all are taken, the entry accepted
// longest ago is replaced. RT: yes. Threads: one.
class HandshakeTimes {
 public:
  // Twice as many as the nodes of a hub (HubPeers::kCapacity).
  static constexpr std::size_t kHosts = 32;

  // Returns true, and notes the time, if it is later than all before of this role and host. Pre: role is a node's.
  bool accept(KeyRole role, std::uint64_t host, std::int64_t timestamp_ns) noexcept {
    auto& entries = entries_[static_cast<std::size_t>(role) - kFirstKeyRole];
    const auto known = std::find_if(entries.begin(), entries.end(), [&](const Entry& e) { return e.number != 0 && e.host == host; });
    if (known != entries.end() && timestamp_ns <= known->timestamp_ns) return false;
    Entry& entry = known != entries.end() ? *known : *std::min_element(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
      return a.number < b.number;
    });
    entry = {host, timestamp_ns, ++newest_number_};
    return true;
  }

 private:
  struct Entry {
    std::uint64_t host = 0;
    std::int64_t timestamp_ns = std::numeric_limits<std::int64_t>::min();
    std::uint64_t number = 0;  // number of the newest handshake accepted from this host; 0: free
  };
  std::array<std::array<Entry, kHosts>, kNodeKeyRoles> entries_ = {};
  std::uint64_t newest_number_ = 0;
};

}  // namespace hapton
